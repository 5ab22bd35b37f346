/** The photos that the coach asks for: lettered, in words, and on the dial. */
import type { Schemas } from "../../api/client";
import { t } from "../../texts";
import { type DialData, HIGH_DEG } from "../dial";

type Answer = Schemas["Check"]["answer"];

/** Half of what a photo that is asked for takes on the dial. */
const HALF_DEG = 12;
const MOST = 12;
const SIDES = [
  "dial.w.front",
  "dial.w.right.front",
  "dial.w.right",
  "dial.w.right.back",
  "dial.w.back",
  "dial.w.left.back",
  "dial.w.left",
  "dial.w.left.front",
] as const;

interface Addition {
  readonly letter: string;
  readonly azimuth_deg: number;
  readonly high: boolean;
  readonly words: string;
}

/** The photos asked for, with the letters that the dial and the tiles show. */
export function additions({ missing }: NonNullable<Answer>): Addition[] {
  const all = missing.flatMap((gap) => gap.azimuths_deg.map((azimuth_deg, i) => ({ azimuth_deg, elevation_deg: gap.elevations_deg[i] })));
  return all.slice(0, MOST).map(({ azimuth_deg, elevation_deg }, i) => ({
    letter: String.fromCharCode(65 + i),
    azimuth_deg,
    high: isHigh(elevation_deg),
    words: placeWords(azimuth_deg, elevation_deg),
  }));
}

/** Where that is, in words, for somebody who stands at photo 1. */
export function placeWords(azimuth_deg: number, elevation_deg: number | undefined): string {
  const around = ((azimuth_deg % 360) + 360) % 360;
  const side = t(SIDES[Math.round(around / 45) % 8]);
  return isHigh(elevation_deg) ? t("dial.high", side) : side;
}

const isHigh = (elevation_deg: number | undefined) => (elevation_deg ?? 0) >= HIGH_DEG;

export function dialOf(answer: Answer | null | undefined): DialData | null {
  if (!answer) return null;
  const add = additions(answer);
  return {
    photos: answer.photos
      .filter((one) => one.placed && one.azimuth_deg !== null)
      .map((one) => ({ name: one.name, azimuth_deg: one.azimuth_deg as number, elevation_deg: one.elevation_deg ?? 0 })),
    gaps: add.map((one) => ({ from_deg: one.azimuth_deg - HALF_DEG, to_deg: one.azimuth_deg + HALF_DEG, high: one.high })),
    add,
  };
}
