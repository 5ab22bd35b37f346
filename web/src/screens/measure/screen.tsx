/**
 * Measure: does my tape agree? Girths by level beside the limb, with a column for the tape.
 *
 * A conflict is judged by the server, and comes first. A reading counts as kept once the server says so;
 * until it has also compared it, nothing is said of agreement.
 */
import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";

import { Button, Notice } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { href } from "../../state/route";
import { t } from "../../texts";
import { Stage, type Shown } from "../../viewer/stage";
import type { Mode } from "../../viewer/surface";
import type { CaseProps } from "../open-case";
import { Agreement } from "./agreement";
import { Curve } from "./curve";
import { LevelTable } from "./level-table";
import { Lengths } from "./lengths";
import { useMeasured } from "./measured";
import { MeasureSettings } from "./settings";
import { useTape } from "./tape";

export function MeasureScreen({ openCase }: CaseProps) {
  const measured = useMeasured(openCase);
  const { limb, asked, aligned, level, measures, found } = measured;
  const tape = useTape(openCase, measured);
  const mode = useSignal<Mode>("surface");
  const shown = useMemo<Shown | null>(() => (limb ? { surface: limb.fetched.data, frame: limb.frame, aligned } : null), [limb]);
  const edited = openCase.info.steps.some((step) => step.name === "rectify" && step.state === "done");
  return (
    <div class="work">
      <Stage shown={shown} label={t("stage.limb")} mode={mode} modes={["surface", "photo", "sure"]} level={level} keys={t("measure.keys")} marks={[]}>
        {asked.refused.value && (
          <div class="stage-note">
            <Refusal refused={asked.refused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("step.measure")}>
        <h1 class="unseen">{t("step.measure")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <Agreement measured={measured} tape={tape} />
            {aligned && !found && measures.busy.value && (
              <p class="soft small-note" role="status">
                {t("measure.busy")}
              </p>
            )}
            <Refusal refused={tape.refused ?? measures.refused.value} />
            {!aligned && limb && (
              <Notice
                tone="plain"
                title={t("measure.needs")}
                action={
                  <a class="btn" href={href.step(openCase.id, "align")}>
                    {t("step.align")}
                  </a>
                }
              />
            )}
          </section>
          {found && <LevelTable measured={measured} tape={tape} />}
          {found && (
            <section>
              <h3>{t("measure.curve")}</h3>
              <Curve levels={found.levels} tape={tape.readings} from={measured.from} />
            </section>
          )}
          {found && found.lengths.length > 0 && <Lengths lengths={found.lengths} />}
          <MeasureSettings measured={measured} edited={edited} onSheet={() => void tape.act.run(measured.sheet)} />
        </div>
        <div class="next">
          <Button
            go
            big
            trailing="next"
            off={!aligned ? t("measure.needs") : tape.waits ? tape.comparing : tape.act.busy.value ? t("loading") : null}
            onClick={() => void tape.goOn()}
          >
            {tape.conflicts.length ? t("measure.next.anyway") : t("measure.next")}
          </Button>
          {tape.conflicts.length > 0 && <p class="small soft">{t("measure.next.why")}</p>}
        </div>
      </aside>
    </div>
  );
}
