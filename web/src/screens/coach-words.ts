/**
 * What the coach says, in the language chosen: shortly where its findings are of the usual kinds, else in
 * their own words.
 */
import type { Schemas } from "../api/client";
import { fixed } from "../numbers";
import { type TextKey, t } from "../texts";
import { advice, type Finding, sentence } from "../words";

type Answer = NonNullable<Schemas["Check"]["answer"]>;
type Missing = Answer["missing"][number];

export interface CoachWords {
  readonly lead: string;
  readonly why: string;
}

/** What a check says of the photos that are here: its answer, unless others have come or gone since. */
export function checkWords({ current }: Pick<Schemas["Check"], "current">, answer: Answer): CoachWords {
  return answer.go && !current ? { lead: t("capture.changed"), why: t("capture.changed.why") } : coachWords(answer);
}

/** The answer in one line, and what it rests on. */
export function coachWords(answer: Answer): CoachWords {
  if (answer.go) return { lead: t("capture.go"), why: t(answer.kept_still === false ? "coach.moved.go" : "capture.go.why") };
  const said = reasons(answer);
  if (said[0]) return { lead: t("coach.not.yet", said[0]), why: said[1] ?? "" };
  const first = answer.findings[0];
  return first ? { lead: t("coach.not.yet", sentence(first)), why: advice(first) } : { lead: sentence(answer.headline), why: "" };
}

function reasons(answer: Answer): string[] {
  const found: string[] = [];
  const count = answer.missing.reduce((sum, one) => sum + one.count, 0);
  if (count) found.push(t("coach.add", count));
  for (const one of answer.findings) {
    const { photos, least, share } = one.values as Record<string, number>;
    if (one.code === "coach.board_unseen") found.push(t("coach.board", photos, least));
    if (one.code.startsWith("coach.unseen.")) found.push(t("coach.seen", fixed(100 * (1 - share), 0), least));
    if (one.code === "lens.zoomed") found.push(t("coach.zoomed", Number(one.values.count)));
  }
  if (answer.kept_still === false) found.push(t("coach.moved"));
  const apart = answer.photos.filter((one) => one.placed === false).length;
  if (!found.length && apart) return [t("coach.apart", apart, answer.photos.length), t("coach.apart.do")];
  const bad = answer.photos.filter((one) => !one.counts).length;
  if (found.length && bad) found.push(t("coach.bad", bad));
  return found;
}

/** Where to stand for the photos of a gap; `where` says it of each. */
export function standWords(one: Missing, where: readonly string[]): string {
  const places = [...new Set(where)].join("; ");
  return one.between ? t("coach.between", one.count, one.between[0], one.between[1], places) : t("coach.places", one.count, places);
}

const REMARKS: Readonly<Record<string, TextKey>> = {
  "photo.blurred": "remark.blurred",
  "photo.overexposed": "remark.overexposed",
  "photo.underexposed": "remark.underexposed",
  "photo.mirrored": "remark.mirrored",
  "photo.other_lens": "remark.lens",
  "photo.turned": "remark.turned",
  "lens.photo.zoomed": "remark.zoomed",
};

/** What is wrong with a photo, shortly where it is one of the usual things. */
export function remarkWords(remark: Finding | undefined): string {
  if (!remark) return "";
  const known = REMARKS[remark.code];
  return known ? t(known) : sentence(remark);
}

/** The same on the photo's tile, where only few words have room: of what has no short words, that there is a remark. */
export const remarkInShort = (remark: Finding): string => t(REMARKS[remark.code] ?? "remark.other");

/** Whether the check remarks on a photo as burnt out. */
export const someBurnt = (photos: Answer["photos"]): boolean => photos.some((one) => one.remarks.some(({ code }) => code === "photo.overexposed"));
