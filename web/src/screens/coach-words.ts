/**
 * What the coach says, in the language chosen: made of the figures of its answer, not of its sentences.
 *
 * Where the figures do not tell why there is no GO, the server's own sentence stands, in English.
 */
import type { Schemas } from "../api/client";
import { parted } from "../design/refusal";
import { type TextKey, t } from "../texts";

type Answer = NonNullable<Schemas["Check"]["answer"]>;
type Missing = Answer["missing"][number];

export interface CoachWords {
  readonly lead: string;
  readonly why: string;
}

const LEAST_BOARD_PHOTOS = 3;
const LEAST_SEEN = 0.95;
const ZOOMED = /focal length is (longer|shorter)/;

/** The answer in one line, and what it rests on. */
export function coachWords(answer: Answer): CoachWords {
  if (answer.go) return { lead: t("capture.go"), why: t(answer.kept_still === false ? "coach.moved.go" : "capture.go.why") };
  const said = reasons(answer);
  if (said[0]) return { lead: t("coach.not.yet", said[0]), why: said[1] ?? "" };
  const [lead, why] = parted(answer.headline);
  return { lead, why };
}

function reasons(answer: Answer): string[] {
  const found: string[] = [];
  const count = answer.missing.reduce((sum, one) => sum + one.count, 0);
  if (count) found.push(t("coach.add", count));
  if (answer.board_photos !== null && answer.board_photos !== undefined && answer.board_photos < LEAST_BOARD_PHOTOS) found.push(t("coach.board", answer.board_photos));
  const measured = answer.coverage?.measured;
  if (measured !== undefined && measured < LEAST_SEEN) found.push(t("coach.seen", (100 * measured).toFixed(0)));
  const zoomed = answer.photos.filter((one) => one.placed && one.remarks.some((said) => ZOOMED.test(said))).length;
  if (zoomed) found.push(t("coach.zoomed", zoomed));
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

const REMARKS: readonly [RegExp, TextKey][] = [
  [/^blurred/, "remark.blurred"],
  [/^overexposed/, "remark.overexposed"],
  [/^underexposed/, "remark.underexposed"],
  [/^stored mirrored/, "remark.mirrored"],
  [/^taken with/, "remark.lens"],
  [/a program has turned its pixels/, "remark.turned"],
  [ZOOMED, "remark.zoomed"],
];

/** What is wrong with a photo, shortly where it is one of the usual things. */
export function remarkWords(remark: string): string {
  const known = REMARKS.find(([pattern]) => pattern.test(remark));
  return known ? t(known[1]) : remark;
}
