/** Before anything is drawn: how to draw with this tool, and how wide it is; a trimline while its points are set. */
import { Button, NumberField } from "../../design/parts";
import { nearestVertex } from "../../geometry/nearest";
import { triple, vec3 } from "../../geometry/vectors";
import { type TextKey, t } from "../../texts";
import { term } from "../../words";
import type { Workspace } from "./workspace";
import { begun } from "./draft";
import { SIZE_MM, SOFT_MM } from "./drawing";
import { LEAST_TRIM } from "./trimline";

export function DrawingForm({ workspace }: { workspace: Workspace }) {
  const { tool, size, soft } = workspace.drawing;
  const brush = tool.value === "brush";
  return (
    <section class="small-note by-drawing">
      <p class="soft">{t(`rectify.how.${tool.value}` as TextKey)}</p>
      <div class="row2">
        <NumberField
          label={t(brush ? "brush.size" : "soft.edge")}
          unit="mm"
          step={1}
          decimals={0}
          min={SIZE_MM[0]}
          max={SIZE_MM[1]}
          value={size.value}
          onChange={(value) => (size.value = value)}
        />
        {brush && (
          <NumberField
            label={t("soft.edge")}
            unit="mm"
            step={1}
            decimals={0}
            min={SOFT_MM[0]}
            max={SOFT_MM[1]}
            value={soft.value}
            onChange={(value) => (soft.value = value)}
          />
        )}
        {tool.value === "place" && <AtLandmark workspace={workspace} />}
      </div>
    </section>
  );
}

/** An edit at a landmark that is chosen by its name. */
function AtLandmark({ workspace: { limb, base, viewer, drawing, edit } }: { workspace: Workspace }) {
  const places = limb?.reply.places ?? [];
  const choose = (name: string) => {
    const one = places.find((p) => p.name === name);
    const surface = viewer.current?.surface;
    if (!one || !base.data || !surface) return;
    const anchor = vec3(one.position_mm);
    const seed = nearestVertex(base.data.positions, anchor);
    edit.open(begun({ at: one.name, anchor, seed, normal: triple(surface.normals, seed), falloff_mm: drawing.size.value }));
  };
  if (!places.length) return null;
  return (
    <label class="number">
      <span class="label-line">{t("at.place")}</span>
      <span class="field">
        <select value="" onChange={(event) => choose(event.currentTarget.value)}>
          <option value="">{t("choose")}</option>
          {places.map((one) => (
            <option key={one.name} value={one.name}>
              {term(one.name)}
            </option>
          ))}
        </select>
      </span>
    </label>
  );
}

export function TrimlineForm({ workspace: { trimline, keeping, edit, recipe } }: { workspace: Workspace }) {
  const count = trimline.points.value.length;
  return (
    <section class="edit">
      <h2>{t("tool.trimline")}</h2>
      <p class="soft small-note">{t("trimline.points", count)}</p>
      <div class="acts">
        <Button
          go
          class="grow"
          off={keeping.now.value ? t("loading") : count < LEAST_TRIM && t("trimline.few")}
          onClick={() => void recipe.add(trimline.body())}
        >
          {t("trimline.cut")}
        </Button>
        <Button onClick={edit.drop}>{t("drop.edit")}</Button>
      </div>
    </section>
  );
}
