/** What tells the axes: the front, which end is up, the flexion; or degrees by hand once they are set. */
import { Notice, NumberField, Segments } from "../../design/parts";
import type { AxesTurn } from "../../geometry/axes-turn";
import { fixed } from "../../numbers";
import { t } from "../../texts";
import { sentences } from "../edit-words";
import { type Axes, towardsViewer } from "./axes";
import type { Subject } from "./subject";

export function AxesForm({ subject, axes }: { subject: Subject; axes: Axes }) {
  const { limb, aligned, viewer } = subject;
  const { front, flipped, flexion_deg } = axes;
  return (
    <section>
      <h3>{t("align.axis")}</h3>
      <div class="setting">
        <span>{t("align.front")}</span>
        <Segments
          label={t("align.front")}
          value={front.value ? "look" : "places"}
          options={[
            { value: "places", text: t("align.front.places") },
            { value: "look", text: t("align.front.look") },
          ]}
          onChange={(value) => (front.value = value === "places" ? null : towardsViewer(viewer.current))}
        />
      </div>
      <div class="setting">
        <span>{t("align.up")}</span>
        <Segments
          label={t("align.up")}
          value={flipped.value ? "down" : "up"}
          options={[
            { value: "up", text: t("align.up.as") },
            { value: "down", text: t("align.up.turn") },
          ]}
          onChange={(value) => (flipped.value = value === "down")}
        />
      </div>
      {aligned ? (
        <ByHandForm axes={axes} />
      ) : (
        <NumberField
          label={t("align.flexion")}
          unit="°"
          step={1}
          decimals={1}
          min={-120}
          max={120}
          value={flexion_deg.value}
          onChange={(value) => (flexion_deg.value = value)}
        />
      )}
      {aligned && limb && (
        <p class="small faint" style={{ marginTop: "8px" }}>
          {t("align.size", ...limb.reply.size_mm.map((v) => fixed(v, 1)))}
        </p>
      )}
      {limb?.reply.notes.map((one) => (
        <Notice key={sentences(one)} tone="amber" title={sentences(one)} />
      ))}
    </section>
  );
}

function ByHandForm({ axes: { byHand } }: { axes: Axes }) {
  const now = byHand.value;
  const turn = (part: Partial<AxesTurn>) => (byHand.value = { ...byHand.value, ...part });
  return (
    <>
      <h3>{t("align.by.hand")}</h3>
      <p class="small faint">{t("align.by.hand.how")}</p>
      <div class="row3">
        <NumberField
          label={t("align.turn")}
          unit="°"
          step={0.5}
          decimals={1}
          min={-180}
          max={180}
          value={now.turn_deg}
          onChange={(turn_deg) => turn({ turn_deg })}
        />
        <NumberField
          label={t("align.flex")}
          unit="°"
          step={0.5}
          decimals={1}
          min={-60}
          max={60}
          value={now.flex_deg}
          onChange={(flex_deg) => turn({ flex_deg })}
        />
        <NumberField
          label={t("align.lean")}
          unit="°"
          step={0.5}
          decimals={1}
          min={-60}
          max={60}
          value={now.lean_deg}
          onChange={(lean_deg) => turn({ lean_deg })}
        />
      </div>
    </>
  );
}

/** What the hand turned, each way in words with its degrees. */
export function handWords(by: AxesTurn): string {
  const rows: readonly { readonly deg: number; readonly plus: string; readonly minus: string }[] = [
    { deg: by.turn_deg, plus: t("align.turned.left"), minus: t("align.turned.right") },
    { deg: by.flex_deg, plus: t("align.flexed.back"), minus: t("align.flexed.front") },
    { deg: by.lean_deg, plus: t("align.leaned.right"), minus: t("align.leaned.left") },
  ];
  return rows
    .filter(({ deg }) => deg !== 0)
    .map(({ deg, plus, minus }) => `${fixed(Math.abs(deg), 1)}° ${deg > 0 ? plus : minus}`)
    .join(", ");
}
