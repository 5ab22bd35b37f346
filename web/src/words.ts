/**
 * The sentence of a finding in the language chosen: by the program's own files of words, which say by
 * which rules (`limbgram/findings/tell.py`). The server sends code and values, and the words once.
 */
import { signal } from "@preact/signals";

import { decimalsOf, marked } from "./numbers";
import { type Language, language } from "./texts";

export type Value = null | boolean | number | string | Finding | readonly Value[];

export interface Finding {
  readonly code: string;
  readonly gravity: string;
  /** Each a `Value`; the server's description says no more than that they are JSON. */
  readonly values: Readonly<Record<string, unknown>>;
  /** In English, for readers without the words. */
  readonly sentence?: string;
}

interface Entry {
  /** What, in one sentence. */
  readonly says: string;
  /** What follows it, before the advice. */
  readonly why?: string;
  readonly do?: string;
  /** For one line of a list; empty where `says` is short enough. */
  readonly short?: string;
}

/** What is said of each code, and the names of things by their English ones. */
export interface Words {
  readonly codes: Readonly<Record<string, Entry>>;
  readonly terms: Readonly<Record<string, string>>;
}

export const words = signal<Partial<Record<Language, Words>>>({});

/** Whether two findings say the same. */
export const same = (one: Finding, other: Finding) => one.code === other.code && JSON.stringify(one.values) === JSON.stringify(other.values);

/** What is found, for a title, and what else is to be said. */
export interface Parts {
  readonly what: string;
  readonly more: string;
}

/** What is found, and what to do about it. */
export function told(finding: Finding): string {
  return joined(sentence(finding), advice(finding));
}

/** The same with what is found by itself; a finding that only hands on another is parted as that one is. */
export function inParts(finding: Finding): Parts {
  const entry = entryOf(finding);
  if (!entry) return { what: sentence(finding), more: "" };
  const values = valuesOf(finding);
  const handedOn = values[/^\{(\w+)\}$/.exec(entry.says)?.[1] ?? ""];
  const first = isFinding(handedOn) ? inParts(handedOn) : { what: filled(entry.says, values), more: "" };
  return { what: first.what, more: joined(first.more, filled(entry.why ?? "", values), advice(finding)) };
}

const joined = (...texts: readonly string[]): string => texts.filter(Boolean).join(" ");

const entryOf = (finding: Finding): Entry | undefined => words.value[language.value]?.codes[finding.code];

/** What is found, and why. */
export function sentence(finding: Finding): string {
  const entry = entryOf(finding);
  return entry ? filled(joined(entry.says, entry.why ?? ""), valuesOf(finding)) : (finding.sentence ?? finding.code);
}

/** What to do about it. */
export function advice(finding: Finding): string {
  const entry = entryOf(finding);
  return entry?.do ? filled(entry.do, valuesOf(finding)) : "";
}

/** What is found, in one line; the sentence of a finding that has no short words. */
export function briefly(finding: Finding): string {
  const entry = entryOf(finding);
  return entry?.short ? filled(entry.short, valuesOf(finding)) : sentence(finding);
}

/** A thing's name, by its English one. */
export function term(name: string): string {
  return named(name, "term");
}

const NAMED = ["term", "axis", "kind", "part"];

function named(name: string, what: string): string {
  const known = words.value[language.value]?.terms;
  const whole = known?.[`${what} ${name}`] ?? known?.[name];
  if (whole !== undefined || !/, |: /.test(name)) return whole ?? name;
  return name
    .split(/(, |: )/)
    .map((one) => (/^(, |: )$/.test(one) ? one : named(one, what)))
    .join("");
}

const valuesOf = (finding: Finding) => finding.values as Readonly<Record<string, Value>>;

/** A template with its values put in. */
export function filled(template: string, values: Readonly<Record<string, Value>>): string {
  let text = "";
  for (let at = 0; at < template.length;) {
    if (template.startsWith("{{", at) || template.startsWith("}}", at)) {
      text += template[at];
      at += 2;
    } else if (template[at] === "{") {
      const end = closing(template, at);
      const [, name, quoted, how] = /^(\w+)(!r)?(?::([\s\S]*))?$/.exec(template.slice(at + 1, end)) ?? [];
      const value = values[name] ?? null;
      text += quoted ? cut(quote(value), how ?? "") : said(value, how ?? "", values);
      at = end + 1;
    } else text += template[at++];
  }
  return text;
}

function said(value: Value, how: string, values: Readonly<Record<string, Value>>): string {
  if (how.includes("|")) return filled(chosen(value, how), values);
  if (value === null) return "?";
  if (typeof value === "boolean") return String(value);
  if (typeof value === "number") return formatted(value, how);
  if (typeof value === "string") return NAMED.includes(how) ? named(value, how) : cut(value, how);
  if (isFinding(value)) return clause(value, how);
  return several(value, how, values);
}

export const isFinding = (value: unknown): value is Finding => typeof value === "object" && value !== null && "code" in value;

function chosen(value: Value, how: string): string {
  const alternatives = split(how);
  const keyed = alternatives.map((one) => /^([\w ./-]*)=([\s\S]*)$/.exec(one));
  if (keyed.every((one) => one !== null)) {
    const byKey = new Map(keyed.map((one) => [one[1], one[2]]));
    return byKey.get(value === null ? "none" : String(value)) ?? byKey.get("else") ?? "";
  }
  return alternatives[value === 1 ? 0 : 1];
}

function clause(reason: Finding, how: string): string {
  if (!how) return told(reason);
  if (how === "short") return briefly(reason);
  return how === "clause" ? sentence(reason).replace(/\.$/, "") : sentence(reason);
}

const JOINED_BY = { and: { en: "and", de: "und" }, or: { en: "or", de: "oder" } } as const;

function several(items: readonly Value[], how: string, values: Readonly<Record<string, Value>>): string {
  const first = Number(/^first (\d+)$/.exec(how)?.[1] ?? Infinity);
  const [, joint, kind] = /^(and|or)(?: (\w+))?$/.exec(how) ?? [];
  const each = items.map((one) => said(one, joint !== undefined ? (kind ?? "") : how === "lines" || first < Infinity ? "" : how, values));
  if (how === "lines") return each.map((one) => `\n  ${one}`).join("");
  if (each.length > first) return `${each.slice(0, first).join(", ")} ...`;
  if (joint !== undefined && each.length > 1)
    return `${each.slice(0, -1).join(", ")} ${JOINED_BY[joint as keyof typeof JOINED_BY][language.value]} ${each.at(-1)}`;
  const one = items[0];
  return each.join(typeof one === "object" && one !== null && !Array.isArray(one) ? "; " : ", ");
}

function formatted(value: number, how: string): string {
  const half = /^±\.(\d)f$/.exec(how)?.[1];
  if (half !== undefined) return marked(`± ${value.toFixed(decimalsOf(value, Number(half)))}`);
  const [, plus, grouped, places, kind] = /^(\+?)(,?)(?:\.(\d+))?([dfg%]?)$/.exec(how) ?? [];
  const digits = places === undefined ? undefined : Number(places);
  let text: string;
  if (kind === "f") text = value.toFixed(digits ?? 6);
  else if (kind === "%") text = `${(100 * value).toFixed(digits ?? 6)}%`;
  else if (kind === "g") text = String(Number(value.toPrecision(digits ?? 6)));
  else text = String(value);
  if (Number.parseFloat(text) === 0) text = text.replace("-", "");
  if (grouped) text = text.replace(/^-?\d+/, (whole) => whole.replace(/\B(?=(\d{3})+$)/g, ","));
  if (plus && !text.startsWith("-")) text = `+${text}`;
  return marked(text);
}

function quote(value: Value): string {
  const text = String(value);
  return text.includes("'") && !text.includes('"') ? `"${text}"` : `'${text.replaceAll("'", "\\'")}'`;
}

function cut(text: string, how: string): string {
  const most = /^\.(\d+)$/.exec(how)?.[1];
  return most === undefined ? text : text.slice(0, Number(most));
}

/** Where the brace that opens here is closed. */
function closing(text: string, start: number): number {
  let depth = 0;
  for (let at = start; at < text.length; at++) {
    if (text[at] === "{") depth++;
    else if (text[at] === "}" && --depth === 0) return at;
  }
  throw new Error(`${text} closes no brace`);
}

function split(how: string): string[] {
  const parts = [""];
  let depth = 0;
  for (const letter of how) {
    if (letter === "{") depth++;
    else if (letter === "}") depth--;
    if (letter === "|" && depth === 0) parts.push("");
    else parts[parts.length - 1] += letter;
  }
  return parts;
}
