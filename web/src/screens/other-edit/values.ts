/** What is typed into a parameter's field, and what the field offers. */
import { type Parameter, choiceOf } from "../../edits";
import { numberIn, typedAs } from "../../numbers";
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
export function usual({ default: of }: Parameter): string {
  if (typeof of === "number") return typedAs(of);
  return of === null || of === undefined || Array.isArray(of) ? "" : String(of);
}

/** Between what a number may lie, where that is no matter of course. */
export function rangeOf(p: Pick<Parameter, "least" | "most" | "above" | "unit">): string {
  if (typeof p.least !== "number" || typeof p.most !== "number" || p.most >= LONGEST) return "";
  const most = [typedAs(p.most), unitOf(p)].filter(Boolean).join("\u00a0");
  return t(p.above ? "other.range.above" : "other.range", typedAs(p.least), most);
}

/** The unit of a parameter as people write it. */
export const unitOf = ({ unit }: Pick<Parameter, "unit">): string => (unit === "deg" ? "°" : unit);

/** What was typed as the server wants it: a number, a list of numbers, yes or no, or a word. */
export function valueOf(text: string, p: Pick<Parameter, "expected" | "several">): unknown {
  if (p.expected === YES_OR_NO) return text === "true";
  if (!p.several) return numberIn(text) ?? text;
  const parts = partsOf(text);
  const numbers = parts.map(numberIn);
  return numbers.includes(null) ? parts : numbers;
}

/** A list as it is typed: between semicolons a comma is a decimal mark, without them it parts numbers too. */
const partsOf = (text: string): string[] => text.split(text.includes(";") ? /[;\s]+/ : /[,\s]+/).filter(Boolean);
