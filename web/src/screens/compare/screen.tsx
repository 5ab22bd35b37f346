/**
 * Compare: what is different from another shape, where, and does it matter for the fit?
 *
 * The server lays the shapes on each other, never scaled, and its one answer has the map and the
 * figures. How they were laid stands beside the figures, because it decides what they mean.
 */
import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";

import { Button, Notice } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { IDENTITY } from "../../geometry/vectors";
import { useQuery } from "../../state/requests";
import { go, href } from "../../state/route";
import { expert } from "../../state/settings";
import { t } from "../../texts";
import { Stage, type Shown } from "../../viewer/stage";
import type { Mode } from "../../viewer/surface";
import { told } from "../../words";
import type { CaseProps } from "../open-case";
import { type Against, isOwn, wordsFor } from "./against";
import { Answer } from "./answer";
import { type Way, type Which, compared, widest } from "./compared";
import { HowLaid } from "./how-laid";
import { Levels } from "./levels";
import { OtherShape } from "./other-shape";

export function CompareScreen({ openCase }: CaseProps) {
  const edited = openCase.info.steps.some((step) => step.name === "rectify" && step.state === "done");
  const mode = useSignal<Mode>("difference");
  const level = useSignal<number | null>(null);
  const of = useSignal<Which>(edited ? "rectified" : "scan");
  const against = useSignal<Against | null>(edited ? { what: "scan" } : null);
  const way = useSignal<Way>("auto");
  const spacing_mm = useSignal(20);
  const found = useQuery(async () => {
    const other = against.value;
    return other && { ...(await compared(openCase.id, of.value, other, way.value, spacing_mm.value)), against: other };
  }, [openCase.id, of.value, against.value, way.value, spacing_mm.value, openCase.changes.work]);
  const one = found.value.value;
  const busy = found.busy.value;
  /** What the map and the figures are of: while another one is asked for, and where that is refused, the one before. */
  const laidOn = t("compare.against", wordsFor(one?.against ?? null));
  const shown = useMemo<Shown | null>(
    () =>
      one
        ? { surface: one.surface, frame: IDENTITY, aligned: one.figures.anatomical_frame, difference: { values: one.values, wider: widest(one.values) } }
        : null,
    [one],
  );
  const setOf = (value: Which) => {
    of.value = value;
    if (value === "scan" && isOwn(against.value)) against.value = null;
  };
  return (
    <div class="work">
      <Stage
        shown={shown}
        label={t("stage.compare")}
        mode={mode}
        modes={["difference", "surface"]}
        level={level}
        keys={t("compare.keys")}
        against={laidOn}
        ends={[t("compare.smaller"), t("compare.larger")]}
        hatched={one?.values.some((v) => !Number.isFinite(v)) ? t("compare.nothing.near") : undefined}
      >
        {!one && !busy && !found.refused.value && (
          <div class="stage-note">
            <Notice tone="plain" title={t("compare.begin")}>
              {t("compare.begin.how")}
            </Notice>
          </div>
        )}
        {busy && (
          <p class="stage-wait" role="status">
            {t("compare.busy")}
          </p>
        )}
        {found.refused.value && (
          <div class="stage-note">
            <Refusal refused={found.refused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("compare")}>
        <h1 class="unseen">{t("compare")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          {one && <Answer figures={one.figures} against={laidOn} busy={busy} />}
          {one && one.figures.notes.length > 0 && (
            <section>
              <h3>{t("notes")}</h3>
              <ul class="findings small-note soft">
                {one.figures.notes.map(told).map((text) => (
                  <li key={text}>{text}</li>
                ))}
              </ul>
            </section>
          )}
          <OtherShape openCase={openCase} against={against} scan={edited && of.value === "rectified"} before={of.value === "rectified"} />
          <HowLaid of={of.value} onlyScan={!edited} onOf={setOf} way={way} spacing_mm={spacing_mm} />
          {one && <Levels figures={one.figures} level={level.value} onLevel={(h) => (level.value = h)} />}
          {expert.value && one && <section class="mono">{told(one.figures.verdict)}</section>}
        </div>
        <div class="next">
          <Button go big trailing="next" onClick={() => go(href.step(openCase.id, edited ? "send" : "rectify"))}>
            {t(edited ? "rectify.next" : "measure.next")}
          </Button>
        </div>
      </aside>
    </div>
  );
}
