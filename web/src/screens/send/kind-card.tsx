/** What kind of file, and what its receiver expects of it. */
import { useSignal } from "@preact/signals";

import { NumberField } from "../../design/parts";
import { type ExportKind, exportKinds, fieldOf, fileName, limitsOf, usedFor } from "../../formats";
import { t } from "../../texts";
import { Card } from "./card";
import { ASKED, type Export } from "./export";

export function KindCard({ made: { kind, valueOf, enter, write } }: { made: Export }) {
  const more = useSignal(false);
  /** Whether the fields of an AOP file's grid are open. */
  const grid = useSignal(false);
  const kinds = exportKinds.value;
  const shown = kinds.find((one) => one.kind === kind.value);
  const all = more.value || shown?.everyday === false;
  const option = (one: ExportKind) => (
    <label key={one.kind} class={`opt ${one === shown ? "on" : ""}`}>
      <input type="radio" name="kind" checked={one === shown} onChange={() => write({ kind: one.kind })} />
      <b>{fileName(one.kind)}</b>
      <small>{usedFor(one)}</small>
    </label>
  );
  return (
    <Card step={1} done title={t("send.what")}>
      <div class="opts">{kinds.filter((one) => one.everyday).map(option)}</div>
      {all && <div class="opts">{kinds.filter((one) => !one.everyday).map(option)}</div>}
      <p class="opt-links">
        {!all && (
          <button type="button" class="linkish" onClick={() => (more.value = true)}>
            {t("send.more")}
          </button>
        )}
        {shown?.kind === "aop" && !grid.value && (
          <span class="soft small-note">
            {t("send.grid", valueOf("aop", "spokes") ?? "", valueOf("aop", "spacing_mm") ?? "")}{" "}
            <button type="button" class="linkish" onClick={() => (grid.value = true)}>
              {t("send.grid.change")}
            </button>
          </span>
        )}
      </p>
      {ASKED[kind.value] && (kind.value !== "aop" || grid.value) && (
        <div class="own-board">
          {ASKED[kind.value]?.map(({ name, label, step, decimals }) => (
            <NumberField
              key={kind.value + name}
              label={t(label)}
              unit={fieldOf(kind.value, name)?.unit ?? ""}
              step={step}
              decimals={decimals}
              {...limitsOf(kind.value, name)}
              value={valueOf(kind.value, name) ?? null}
              onChange={(value) => enter(kind.value, name, value)}
            />
          ))}
        </div>
      )}
    </Card>
  );
}
