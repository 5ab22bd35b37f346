/** Readings of the tape as they are shown: what the server keeps, what is on its way to it, and what it says of each. */
import type { Schemas } from "../api/client";
import figures from "../api/figures.json";
import type { Act } from "../state/acts";

type Kept = Schemas["Reading"];

export interface Reading extends Kept {
  /** What the server says of this very girth; null: it has not compared it yet. */
  readonly verdict: Schemas["TapeReply"] | null;
}

/** Heights so near are one, for the server too. */
export const heightIs = (one_mm: number, other_mm: number): boolean => Math.abs(one_mm - other_mm) <= figures.SAME_HEIGHT_MM;

/** The readings once the acts that are pending are done. */
export function withPending(kept: readonly Kept[], acts: readonly Pick<Act, "init">[]): Kept[] {
  let readings = [...kept];
  for (const { init } of acts) {
    const { height_mm, girth_mm } = init.body as Schemas["ReadingChange"];
    readings = readings.filter((one) => !heightIs(one.height_mm, height_mm));
    if (girth_mm !== null && girth_mm !== undefined) readings.push({ height_mm, girth_mm });
  }
  return readings.sort((a, b) => a.height_mm - b.height_mm);
}

/** Each reading with what was said of that girth at that height; what was said of another girth is not said of it. */
export function judged(readings: readonly Kept[], said: readonly Schemas["TapeReply"][]): Reading[] {
  return readings.map((one) => ({ ...one, verdict: said.find((of) => heightIs(of.height_mm, one.height_mm) && of.girth_mm === one.girth_mm) ?? null }));
}
