/** Side, kind and note of a case: asked where it is made, and where they are changed. */
import type { Schemas } from "../../api/client";
import { SideBadge } from "../../design/parts";
import { kindName, limbKinds } from "../../limb-kinds";
import { t } from "../../texts";

type Case = Schemas["Case"];

export function CaseFields({ note, side, kind }: { note: { value: string }; side: { value: Case["side"] | null }; kind: { value: Case["kind"] | null } }) {
  return (
    <div class="case-fields">
      <fieldset>
        <legend>{t("cases.which.side")}</legend>
        <div class="choices">
          {(["right", "left"] as const).map((one) => (
            <label key={one} class={`choice ${side.value === one ? "on" : ""}`}>
              <input type="radio" name="side" checked={side.value === one} onChange={() => (side.value = one)} />
              <SideBadge side={one} />
            </label>
          ))}
        </div>
      </fieldset>
      <fieldset>
        <legend>{t("cases.which.kind")}</legend>
        <div class="choices">
          {limbKinds.value.map((one) => (
            <label key={one.kind} class={`choice ${kind.value === one.kind ? "on" : ""}`}>
              <input type="radio" name="kind" checked={kind.value === one.kind} onChange={() => (kind.value = one.kind)} />
              {kindName(one.kind)}
            </label>
          ))}
        </div>
      </fieldset>
      <label class="stacked">
        <span>{t("cases.name")}</span>
        <span class="field">
          <input maxLength={200} value={note.value} onInput={(event) => (note.value = event.currentTarget.value)} />
        </span>
        <span class="small faint">{t("cases.no.name")}</span>
      </label>
    </div>
  );
}
