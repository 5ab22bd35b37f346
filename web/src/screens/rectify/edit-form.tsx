/** The edit that is open, in figures: its depth and edges, what it does to the limb, and whether it is kept. */
import { Button, Notice, NumberField, Segments } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { fixed, signed } from "../../numbers";
import { t } from "../../texts";
import { askedBy, sentences } from "../edit-words";
import { type Workspace, keepDrawn } from "./workspace";
import { type Draft, wayOf } from "./draft";
import { type Girth, toneOf, volumeOf } from "./effect";

export function EditForm({ workspace, draft, girth }: { workspace: Workspace; draft: Draft; girth: Girth | null }) {
  const { edit, trial, keeping } = workspace;
  const { change } = edit;
  return (
    <section class="edit">
      <div class="row-head">
        <h2>{t(draft.kind === "load" ? "load.head" : "relief.head")}</h2>
        <span class="grow" />
        <Segments
          label={t("load.or.relief")}
          value={draft.kind}
          options={[
            { value: "load", text: t("load") },
            { value: "relieve", text: t("relief") },
          ]}
          onChange={(kind) => change({ kind })}
        />
      </div>
      <div class="row2">
        <NumberField
          label={t(draft.kind === "load" ? "depth.in" : "depth.out")}
          unit="mm"
          step={0.1}
          decimals={2}
          min={0.1}
          max={60}
          value={draft.depth_mm}
          onChange={(depth_mm) => change({ depth_mm })}
        />
        <NumberField
          label={t("soft.edge")}
          unit="mm"
          step={1}
          decimals={1}
          min={1}
          max={200}
          value={draft.falloff_mm}
          onChange={(falloff_mm) => change({ falloff_mm })}
        />
        {!draft.within.length && (
          <NumberField label={t("flat")} unit="mm" step={1} decimals={1} min={0} max={100} value={draft.flat_mm} onChange={(flat_mm) => change({ flat_mm })} />
        )}
      </div>
      <Effect girth={girth} volume_ml={volumeOf(workspace)} waits={trial.waits.value} />
      {trial.tried.value?.line?.concerns.map((one) => (
        <Notice key={sentences(one.finding)} tone="amber" title={sentences(one.finding)} />
      ))}
      <Asked workspace={workspace} draft={draft} />
      {edit.asksDepth.value && (
        <Notice
          tone="amber"
          title={t("deep", fixed(draft.depth_mm, 1))}
          action={<Button onClick={() => (edit.asksDepth.value = false)}>{t("is.meant")}</Button>}
        />
      )}
      <div class="acts">
        <Button go class="grow" off={keeping.now.value ? t("loading") : trial.refused.value ? t("refused.first") : null} onClick={() => keepDrawn(workspace)}>
          {t("keep")}
        </Button>
        <Button onClick={edit.drop}>{t("drop.edit")}</Button>
      </div>
    </section>
  );
}

function Effect({ girth, volume_ml, waits }: { girth: Girth | null; volume_ml: number | null; waits: boolean }) {
  return (
    <div class={`eff ${waits ? "waits" : ""}`}>
      {girth && (
        <span>
          {t("girth.at", fixed(girth.height_mm, 0))} <b class={toneOf(girth.change_mm)}>{signed(girth.change_mm)} mm</b>
        </span>
      )}
      {volume_ml !== null && (
        <span>
          {t("volume")} <b class={volume_ml < 0 ? "neg" : "pos"}>{signed(volume_ml)} mL</b>
        </span>
      )}
    </div>
  );
}

/** Why the server does not make it: what it asks a word for can be said to be meant. */
function Asked({ workspace: { edit, trial }, draft }: { workspace: Workspace; draft: Draft }) {
  const refused = trial.refused.value;
  const asked = askedBy(refused?.finding ?? null);
  if (!asked) return <Refusal refused={refused} />;
  return (
    <Notice tone="red" title={asked.what} action={<Button onClick={() => edit.change({ accept: [...draft.accept, ...asked.words] })}>{t("is.meant")}</Button>}>
      <p>{t("concern.do")}</p>
    </Notice>
  );
}

/** Beside the handle while the depth is dragged. */
export function DepthCard({ draft, girth }: { draft: Draft; girth: Girth | null }) {
  const outward_mm = wayOf(draft) * draft.depth_mm;
  const inwards = wayOf(draft) < 0;
  return (
    <div class="hint-card at-handle" role="status">
      <b class={`big ${inwards ? "neg" : "pos"}`}>{signed(outward_mm)} mm</b> <span class="soft">{t(inwards ? "carved" : "built")}</span>
      {girth && (
        <>
          <br />
          <span class="soft">{t("girth.at", fixed(girth.height_mm, 0))}</span> <b>{fixed(girth.now_mm, 1)} mm</b>{" "}
          <span class={toneOf(girth.change_mm)}>({signed(girth.change_mm)})</span>
        </>
      )}
    </div>
  );
}
