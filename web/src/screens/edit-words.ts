/** The server's words about edits, in the language chosen: a name is the key, numbers are put in. */
import type { Schemas } from "../api/client";
import { innermost } from "../design/refusal";
import { fixed, signed, typedAs } from "../numbers";
import { choiceOf, editName, labelOf } from "../edits";
import { t } from "../texts";
import { type Finding, term, told } from "../words";

/** What an edit is called, where it works, and its number to change later. */
export function summaryOf(one: Schemas["EditReply"]): { title: string; where: string; amount: string; field: string | null } {
  const p = one.parameters as Record<string, unknown>;
  const depth = Number(p.depth_mm);
  const title = editName(one.kind);
  const within = Array.isArray(p.within) && p.within.length > 0;
  const where = within ? t("drawn.region") : typeof p.at === "string" ? term(p.at) : p.at ? t("a.point") : numbersOf(one);
  if (one.kind === "load" || one.kind === "relieve") return { title, where, amount: `${signed(one.kind === "load" ? -depth : depth)} mm`, field: "depth_mm" };
  if (one.kind === "from-template")
    return {
      title,
      where: templateName(p.learned),
      amount: `${fixed(100 * Number(p.strength), 0)} %`,
      field: null,
    };
  const thickness = Number(p.thickness_mm ?? p.distance_mm ?? p.offset_mm);
  return { title, where, amount: Number.isFinite(thickness) ? `${typedAs(thickness)} mm` : "", field: null };
}

/** What a template is called, by its file, which is JSON; nothing of one that no program reads. */
function templateName(file: unknown): string {
  try {
    return String((JSON.parse(String(file)) as { name?: unknown }).name ?? "");
  } catch {
    return "";
  }
}

/** What was given of an edit, by its words: "Heights 80, 200; per cent 1, 3". */
function numbersOf(one: Schemas["EditReply"]): string {
  const p = one.parameters as Record<string, unknown>;
  if (Array.isArray(p.through)) return t("trimline.along", p.through.length);
  const given = one.telling.filter((name) => name in p && name !== "positions_in");
  return given.map((name) => `${labelOf(one.kind, name)} ${valueOf(one.kind, p[name])}`).join("; ");
}

function valueOf(kind: string, value: unknown): string {
  if (Array.isArray(value)) return value.map((each) => valueOf(kind, each)).join(", ");
  if (typeof value === "boolean") return t(value ? "yes" : "no");
  return typeof value === "string" ? (choiceOf(kind, value) ?? term(value)) : typeof value === "number" ? typedAs(value) : String(value);
}

/** A finding as sentences of their own. */
export function sentences(one: Schemas["FindingReply"] | Finding): string {
  const text = told(one as Finding);
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;
}

/** What an edit asks a word for, and the words; null of a refusal for anything else. */
export function askedBy(finding: Finding | null): { what: string; words: readonly string[] } | null {
  const asks = innermost(finding);
  if (asks?.code !== "recipe.asks" && asks?.code !== "recipe.edit.asks") return null;
  const { concerns, words } = asks.values as { concerns: readonly Finding[]; words: readonly string[] };
  return { what: concerns.map(sentences).join(" "), words };
}

/** What the colours are held against, and whether the scan still has its sock on, where that is recorded. */
export function scanWords(sockOff_mm: number, edits: readonly Pick<Schemas["EditReply"], "kind" | "on">[]): string {
  if (sockOff_mm > 0) return t("against.scan.off");
  return t(edits.some((one) => one.kind === "sock" && one.on) ? "against.scan.on" : "against.scan");
}
