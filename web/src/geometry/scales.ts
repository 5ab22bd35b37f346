/** The two scales of colour: how sure a point is, and how far two surfaces differ. Fixed ranges. */
import figures from "../api/figures.json";

/** ± in mm that hold in 95 of 100 (two sigma), where the colours of "how sure" stand. */
export const SURE_STOPS_MM: readonly number[] = figures.SURE_STOPS_MM;
export const SURE_COLOURS = ["#F6F4F7", "#ECE5F1", "#C4ACD4", "#9B70B2", "#6E3A8A", "#42165C"] as const;

/** Limits of the bands of a difference, in mm, as in the pictures of the report; the middle band lies within the first. */
export const DIFFERENCE_LIMITS_MM: readonly number[] = figures.DIFFERENCE_LIMITS_MM;
export const DIFFERENCE_COLOURS = ["#123E80", "#215EAA", "#5892CE", "#96BCE0", "#F2F1EF", "#ECB8A6", "#DD7860", "#B2342E", "#7E1420"] as const;

/** By how much the limits are multiplied: doubled where anything lies beyond 4 mm, and again. */
export function widthFor(largest_mm: number): number {
  let wider = 1;
  while (largest_mm > 4 * wider && wider < 64) wider *= 2;
  return wider;
}

/** The same for the largest of some differences, mm. */
export function widthOf(differences_mm: Float32Array): number {
  let most = 0;
  for (const d of differences_mm) if (Math.abs(d) > most) most = Math.abs(d);
  return widthFor(most);
}
