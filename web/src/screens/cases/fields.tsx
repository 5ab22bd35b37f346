/** Side, kind and note of a case: asked where it is made, and where they are changed. */
import { useId } from "preact/hooks";

import type { Schemas } from "../../api/client";
import { SideBadge } from "../../design/parts";
import { kindName, limbKinds, sided } from "../../limb-kinds";
import { t } from "../../texts";

type Case = Schemas["Case"];

/** What is still to be said of a case before it is made, in words; nothing where all is said. */
export function lacksOf(side: Case["side"] | null, kind: Case["kind"] | null): string | null {
  if (sided(kind) && !side) return t("cases.which.side");
  return kind ? null : t("cases.which.kind");
}

/** The side of a case, of a kind that has one. */
export const sideOf = (side: Case["side"] | null, kind: Case["kind"] | null): Case["side"] | null => (sided(kind) ? side : null);

export function CaseFields({ note, side, kind }: { note: { value: string }; side: { value: Case["side"] | null }; kind: { value: Case["kind"] | null } }) {
  /** Two forms may be open at once. */
  const form = useId();
  return (
    <div class="case-fields">
      {sided(kind.value) && (
        <fieldset>
          <legend>{t("cases.which.side")}</legend>
          <div class="choices">
            {(["right", "left"] as const).map((one) => (
              <label key={one} class={`choice ${side.value === one ? "on" : ""}`}>
                <input type="radio" name={`side ${form}`} checked={side.value === one} onChange={() => (side.value = one)} />
                <SideBadge side={one} />
              </label>
            ))}
          </div>
        </fieldset>
      )}
      <fieldset>
        <legend>{t("cases.which.kind")}</legend>
        <div class="choices">
          {limbKinds.value.map((one) => (
            <label key={one.kind} class={`choice ${kind.value === one.kind ? "on" : ""}`}>
              <input type="radio" name={`kind ${form}`} checked={kind.value === one.kind} onChange={() => (kind.value = one.kind)} />
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
