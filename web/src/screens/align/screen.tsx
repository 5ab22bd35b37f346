/**
 * Align: where are side, front and axis? Places are marked on the limb, then the axes follow them.
 *
 * A place is set on release, so a hand may slide to it; it is glued to the surface and can be dragged.
 * Navigation stays as it is meanwhile: right-drag, two fingers, wheel, and drags beside the limb.
 */
import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";

import { Button, Chip } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { STILL, isStill, turned } from "../../geometry/axes-turn";
import { go, href } from "../../state/route";
import { t } from "../../texts";
import { Stage, type Shown } from "../../viewer/stage";
import type { Mode } from "../../viewer/surface";
import { term } from "../../words";
import { Loupe } from "../loupe";
import type { CaseProps } from "../open-case";
import { type Axes, useAxes } from "./axes";
import { AxesForm, handWords } from "./axes-form";
import { marksOf } from "./drawn";
import { EarlierVisit } from "./earlier-visit";
import { KindAndSide } from "./kind-and-side";
import { useKeys } from "./keys";
import { PlacesList } from "./places-list";
import { type Placing, usePlacing } from "./placing";
import { type Subject, useSubject } from "./subject";
import { useTool } from "./tool";

export function AlignScreen({ openCase }: CaseProps) {
  const subject = useSubject(openCase);
  const placing = usePlacing(subject);
  const axes = useAxes(subject, placing);
  const tool = useTool(subject, placing);
  useKeys(subject, placing);
  const mode = useSignal<Mode>("photo");
  const { limb, viewer, aligned, asked } = subject;
  const armed = placing.armed.value;
  const byHand = axes.byHand.value;
  const shown = useMemo<Shown | null>(
    () => limb && { surface: limb.fetched.data, frame: turned(limb.frame, byHand), aligned: limb.reply.aligned },
    [limb, byHand],
  );

  return (
    <div class="work">
      <Stage
        shown={shown}
        label={t("stage.limb")}
        mode={mode}
        modes={["surface", "photo", "sure"]}
        marks={marksOf(placing)}
        tool={tool}
        onAxes={aligned && !armed ? axes.drag : undefined}
        onReady={(made) => (viewer.current = made)}
        keys={aligned && !armed ? t("align.keys.axes") : armed ? t("align.keys.armed", term(armed)) : t("align.keys")}
      >
        <Loupe viewer={viewer} on={placing.held.value !== null} />
        {!isStill(byHand) && (
          <div class="hint-card at-handle" role="status">
            <b>{handWords(byHand)}</b>
          </div>
        )}
        {armed && <p class="armed-note">{t("align.now", term(armed))}</p>}
        {asked.refused.value && (
          <div class="stage-note">
            <Refusal refused={asked.refused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("step.align")}>
        <h1 class="unseen">{t("step.align")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <State subject={subject} placing={placing} />
          <section class="tab">
            <PlacesList subject={subject} placing={placing} />
          </section>
          <EarlierVisit visit={placing.visit} />
          <AxesForm subject={subject} axes={axes} />
        </div>
        <Next subject={subject} axes={axes} />
      </aside>
    </div>
  );
}

/** Whether the axes are set, what was done last, and what the case does not tell. */
function State({ subject, placing }: { subject: Subject; placing: Placing }) {
  const { openCase, asked, aligned, kind, side, saved, act } = subject;
  return (
    <section>
      <div class="row-head">
        <h2>{aligned ? t("align.set") : t("align.title")}</h2>
        <span class="grow" />
        {aligned && <Chip tone="green">{t("align.front.set")}</Chip>}
      </div>
      <p class="soft small-note" role="status">
        {saved.value || (aligned ? t("align.set.how") : t("align.how"))}
      </p>
      <Refusal refused={act.refused.value ?? placing.namesRefused.value} />
      {(!kind || !side) && <KindAndSide openCase={openCase} onDone={() => void Promise.all([openCase.again(), asked.again()])} />}
    </section>
  );
}

/** Keep what a hand turned, go on, or set the axes. */
function Next({ subject, axes }: { subject: Subject; axes: Axes }) {
  const { openCase, aligned, act } = subject;
  const { byHand, chosenAnew, lacks } = axes;
  if (!isStill(byHand.value))
    return (
      <div class="next">
        <Button go big off={act.busy.value && t("loading")} onClick={axes.keepByHand}>
          {t("align.by.hand.keep")}
        </Button>
        <p>
          <button type="button" class="linkish" onClick={() => (byHand.value = STILL)}>
            {t("drop.edit")}
          </button>
        </p>
      </div>
    );
  if (aligned && !chosenAnew)
    return (
      <div class="next">
        <Button go big trailing="next" onClick={() => go(href.step(openCase.id, "measure"))}>
          {t("result.next.measure")}
        </Button>
        <p>
          <button type="button" class="linkish" onClick={axes.set}>
            {t("align.again")}
          </button>
        </p>
      </div>
    );
  return (
    <div class="next">
      <Button go big off={lacks} onClick={axes.set}>
        {t("align.confirm")}
      </Button>
      {lacks && <p class="small soft">{lacks}</p>}
    </div>
  );
}
