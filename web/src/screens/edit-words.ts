/** The server's words about edits, in the language chosen: a name is the key, numbers are put in. */
import type { Schemas } from "../api/client";
import { withoutNumbers } from "../design/refusal";
import { signed } from "../geometry/scales";
import { t, tOr } from "../texts";

/** What an edit is called, where it works, and its number to change later. */
export function wordsOf(one: Schemas["EditReply"]): { title: string; where: string; amount: string; field: string | null } {
  const p = one.parameters as Record<string, unknown>;
  const depth = Number(p.depth_mm);
  const title = one.kind === "load" ? t("load") : one.kind === "relieve" ? t("relief") : tOr(`edit.${one.kind}`, one.kind);
  const within = Array.isArray(p.within) && p.within.length > 0;
  const where = within ? t("drawn.region") : typeof p.at === "string" ? tOr(`place.${p.at}`, p.at) : p.at ? t("a.point") : numbersOf(one);
  if (one.kind === "load" || one.kind === "relieve") return { title, where, amount: `${signed(one.kind === "load" ? -depth : depth)} mm`, field: "depth_mm" };
  if (one.kind === "from-template") return { title, where: /"name": ?"((?:[^"\\\\]|\\\\.)*)"/.exec(String(p.learned))?.[1] ?? "", amount: `${(100 * Number(p.strength)).toFixed(0)} %`, field: null };
  const thickness = Number(p.thickness_mm ?? p.distance_mm ?? p.offset_mm);
  return { title, where, amount: Number.isFinite(thickness) ? `${thickness} mm` : "", field: null };
}

/** What was given of an edit, by its words: "Heights 80, 200; per cent 1, 3". */
function numbersOf(one: Schemas["EditReply"]): string {
  const p = one.parameters as Record<string, unknown>;
  if (Array.isArray(p.through)) return t("trimline.along", p.through.length);
  const given = [...one.text.matchAll(/(\w+) = /g)].map((found) => found[1]).filter((name) => name in p && name !== "positions_in");
  return given.map((name) => `${labelOf(name)} ${valueOf(p[name])}`).join("; ");
}

/** What a parameter is called. */
export function labelOf(name: string): string {
  const plain = name.replace(/_(mm|deg)$/, "").replaceAll("_", " ");
  return tOr(`param.${name}`, plain[0].toUpperCase() + plain.slice(1));
}

function valueOf(value: unknown): string {
  if (Array.isArray(value)) return value.map(valueOf).join(", ");
  if (typeof value === "boolean") return t(value ? "yes" : "no");
  return typeof value === "string" ? tOr(`place.${value}`, tOr(`choice.${value}`, value)) : String(value);
}

/** Why an edit needs a word, or what it presses on. A form that is not known stays as the server said it. */
export function concernOf(one: { readonly what: string; readonly word: string }): string {
  const put = /^the load is put on the ([^:]+): (.*)$/.exec(one.what);
  if (put) return t("concern.put", placeOf(put[1]), whyOf(put[2]));
  const presses = /^presses ([\d.]+) mm on the ([^:]+): (.*)$/.exec(one.what);
  if (presses) return t("concern.presses", presses[1], placeOf(presses[2]), whyOf(presses[3]));
  const several = /^presses on (.+)$/.exec(one.what)?.[1].split(", ").map((each) => /^(.+) ([\d.]+) mm$/.exec(each));
  if (several?.every((each) => each !== null)) return t("concern.all", several.map((each) => `${placeOf(each?.[1] ?? "")} ${each?.[2]}\u00a0mm`).join(", "));
  const deep = /^the depth is ([\d.]+) mm, and more than ([\d.]+) mm is unusual$/.exec(one.what);
  if (deep) return t("concern.deep", deep[1], deep[2]);
  const together = /^with the edits before it the surface lies ([\d.]+) mm (inside|outside) the scan, and more than ([\d.]+) mm is unusual$/.exec(one.what);
  if (together) return t(together[2] === "inside" ? "concern.inside" : "concern.outside", together[1], together[3]);
  return one.what;
}

/** A refusal for want of a word: what it is about, each in a sentence. Others are not of this kind. */
export function wordLacks(message: string): string | null {
  const said = /^(?:Not added: this edit: )?(.+)\. A load carves the positive in, so that /s.exec(withoutNumbers(message))?.[1];
  return said ? said.split("; ").map((what) => concernOf({ what, word: "" })).join(" ") : null;
}

/** What the colours are held against, and whether the scan still has its sock on, where that is recorded. */
export function scanWords(sockOff_mm: number, edits: readonly Pick<Schemas["EditReply"], "kind" | "on">[]): string {
  if (sockOff_mm > 0) return t("against.scan.off");
  return t(edits.some((one) => one.kind === "sock" && one.on) ? "against.scan.on" : "against.scan");
}

const placeOf = (name: string) => tOr(`place.${name}`, tOr(`sensitive.${name}`, name));
const whyOf = (why: string) => tOr(`why.${why}`, why);
