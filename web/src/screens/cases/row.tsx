/** A case in the list: what it is, how far it came, what next, and what can be done to it. */
import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { SideBadge } from "../../design/parts";
import { kindName } from "../../limb-kinds";
import { bytes } from "../../numbers";
import { t, when } from "../../texts";
import { useActsOfCase } from "./acts-of-case";
import { AskedFirst } from "./asked-first";
import { More } from "./more";
import { nextOf } from "./next";
import { StateOf } from "./state-of";

export function Row({ one, onChange }: { one: Schemas["Case"]; onChange: () => void }) {
  const next = nextOf(one);
  const acts = useActsOfCase(one.id, onChange);
  const here = one.steps.findIndex((step) => step.name === one.next);
  return (
    <>
      <tr>
        <td class="th">
          {one.thumbnail ? (
            <img class="thumb" src={one.thumbnail} alt="" loading="lazy" width="56" height="56" />
          ) : (
            <span class="thumb none">
              <Icon name={one.state === "photos" ? "camera" : "limb"} />
            </span>
          )}
        </td>
        <td>
          <a class="case-link" href={next.to}>
            {one.id}
          </a>
          <br />
          <span class="faint small">{one.sample ? t("kind.sample") : [kindName(one.kind), one.note].filter(Boolean).join(" · ")}</span>
        </td>
        <td>
          <SideBadge side={one.side} />
        </td>
        <td class="wide-only">
          <span class="soft">{when(one.changed)}</span>
        </td>
        <td>
          <StateOf one={one} />
        </td>
        <td class="wide-only">
          <div class="dots" role="img" aria-label={t("cases.step.of", here + 1, t(`step.${one.next}`))}>
            {one.steps.map((step, i) => (
              <i key={step.name} class={step.state === "done" ? "d" : i === here ? "h" : ""} />
            ))}
          </div>
        </td>
        <td>
          <a class="btn next-btn" href={next.to}>
            {next.text}
          </a>
        </td>
        <td class="num wide-only">
          <span class="soft">{bytes(one.bytes)}</span>
        </td>
        <td>
          <More one={one} acts={acts} />
        </td>
      </tr>
      {(acts.doing.value || acts.refused.value) && (
        <tr>
          <td colSpan={9} class="below">
            <AskedFirst one={one} acts={acts} />
          </td>
        </tr>
      )}
    </>
  );
}
