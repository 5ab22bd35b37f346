/** May the patient go? The answer in words, with its sign. */
import type { Schemas } from "../../api/client";
import type { IconName } from "../../design/icons";
import { t } from "../../texts";
import { told } from "../../words";
import { type CoachWords, checkWords } from "../coach-words";

export interface BannerWords extends CoachWords {
  readonly tone: "green" | "amber" | "";
  readonly icon: IconName;
  /** The shape is computed, and nothing new is here. */
  readonly rests: boolean;
}

export function bannerWords(said: Schemas["Check"] | null, info: Schemas["Case"], photos: number): BannerWords {
  const running = said?.state === "running";
  const rests = info.state === "finished" && !said?.answer && !running;
  const green = rests || goes(said);
  const tone = green ? "green" : !running && (said?.answer || said?.state === "refused") ? "amber" : "";
  const icon = green ? "tick" : tone === "amber" ? "warn" : "camera";
  return { ...wordsOf(said, info, photos, rests), tone, icon, rests };
}

/** Whether the photos that are here now do. */
export const goes = (said: Schemas["Check"] | null): boolean => said?.answer?.go === true && said.current;

/** Whether a case is being computed, or waits for it. */
export const isBusy = ({ state }: Schemas["Case"]): boolean => state === "computing" || state === "held";

function wordsOf(said: Schemas["Check"] | null, info: Schemas["Case"], photos: number, rests: boolean): CoachWords {
  if (isBusy(info)) return { lead: t("capture.computing"), why: "" };
  if (rests) return { lead: t("capture.done"), why: t("capture.done.why") };
  if (said?.state === "running") return { lead: t("capture.checking", said.photos), why: t("capture.checking.why") };
  if (said?.state === "refused" && !goes(said)) return { lead: t("capture.cannot.check"), why: said.finding ? told(said.finding) : "" };
  if (said?.answer) return checkWords(said, said.answer);
  if (photos) return { lead: t("capture.collect"), why: t("capture.begin.why") };
  return info.sample ? { lead: t("capture.sample"), why: t("capture.sample.why") } : { lead: t("capture.begin"), why: t("capture.begin.why") };
}
