/** The field of one parameter: some words, a place of the limb, or what is typed. */
import type { Parameter } from "../../edits";
import { t } from "../../texts";
import { term } from "../../words";
import { choicesOf, unitOf, usual, wordOf } from "./values";

interface Props {
  readonly kind: string;
  readonly parameter: Parameter;
  /** What was typed or chosen; without it the field shows what is usual. */
  readonly value: string | undefined;
  readonly places: readonly string[];
  readonly onValue: (value: string) => void;
  readonly onKeyDown: (event: KeyboardEvent) => void;
}

export function Field({ kind, parameter: p, value, places, onValue, onKeyDown }: Props) {
  return (
    <span class="field">
      {choicesOf(p).length > 0 ? (
        <select value={value ?? usual(p)} onChange={(event) => onValue(event.currentTarget.value)}>
          {p.needed && <option value="">{t("choose")}</option>}
          {choicesOf(p).map((choice) => (
            <option key={choice} value={choice}>
              {wordOf(kind, choice)}
            </option>
          ))}
        </select>
      ) : p.name === "above" ? (
        <select value={value ?? ""} onChange={(event) => onValue(event.currentTarget.value)}>
          <option value="">{term("distal end")}</option>
          {places.map((name) => (
            <option key={name} value={name}>
              {term(name)}
            </option>
          ))}
        </select>
      ) : (
        <input inputMode="decimal" placeholder={usual(p)} value={value ?? ""} onInput={(event) => onValue(event.currentTarget.value)} onKeyDown={onKeyDown} />
      )}
      {p.unit && <span class="u">{unitOf(p)}</span>}
    </span>
  );
}
