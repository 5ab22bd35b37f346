/** What is typed into a parameter's field, and what the field offers. */
import { type Parameter, choiceOf } from "../../edits";
import { t } from "../../texts";
import { term } from "../../words";

/** The server's words for what is either. */
const YES_OR_NO = "true or false";
/** As long as no limb is: a range up to there says nothing. */
const LONGEST = 2000;

/** The words that a parameter may be, where it may be only some. */
export function choicesOf(p: Pick<Parameter, "choices" | "expected">): readonly string[] {
  return p.expected === YES_OR_NO ? ["true", "false"] : (p.choices ?? []);
}

export const wordOf = (kind: string, choice: string) =>
  choice === "true" ? t("yes") : choice === "false" ? t("no") : (choiceOf(kind, choice) ?? term(choice));

/** What counts where nothing is said. */
export const usual = (p: Parameter): string => (p.default === null || p.default === undefined || Array.isArray(p.default) ? "" : String(p.default));

/** Between what a number may lie, where that is no matter of course. */
export function rangeOf(p: Pick<Parameter, "least" | "most" | "above" | "unit">): string {
  if (typeof p.least !== "number" || typeof p.most !== "number" || p.most >= LONGEST) return "";
  const most = p.unit ? `${p.most}\u00a0${p.unit === "deg" ? "°" : p.unit}` : `${p.most}`;
  return t(p.above ? "other.range.above" : "other.range", p.least, most);
}

export const numberOf = (text: string) => Number(text.trim().replace(",", ".").replace("−", "-"));

/** What was typed as the server wants it: a number, a list of numbers, yes or no, or a word. */
export function valueOf(text: string, p: Pick<Parameter, "expected" | "several">): unknown {
  if (p.expected === YES_OR_NO) return text === "true";
  const parts = text
    .split(/[,;]\s*|\s+/)
    .filter(Boolean)
    .map((part) => part.replace("−", "-"));
  const numbers = parts.map(Number);
  if (p.several) return numbers.every(Number.isFinite) ? numbers : parts;
  const one = Number(text.replace(",", ".").replace("−", "-"));
  return Number.isFinite(one) ? one : text;
}
