/** The nearest of many points, by looking at each: for a press of a hand, not for every frame. */
import type { Vec3 } from "./vectors";

/** A place on the page, px. */
export type Pixel = readonly [number, number];

/** The vertex of a surface that is nearest to a point; the first of equals. */
export function nearestVertex(positions: Float32Array, p: Vec3): number {
  let best = 0;
  let least = Infinity;
  for (let i = 0; i < positions.length; i += 3) {
    const gap = (positions[i] - p[0]) ** 2 + (positions[i + 1] - p[1]) ** 2 + (positions[i + 2] - p[2]) ** 2;
    if (gap < least) [best, least] = [i / 3, gap];
  }
  return best;
}

/** Which of some places on the page is nearest to one and nearer than `reach_px`; null stands for a place that is hidden. */
export function nearestPixel(places: readonly (Pixel | null)[], to: Pixel, reach_px: number): number | null {
  let best: number | null = null;
  let least = reach_px;
  places.forEach((at, i) => {
    const gap = at ? Math.hypot(at[0] - to[0], at[1] - to[1]) : Infinity;
    if (gap < least) [best, least] = [i, gap];
  });
  return best;
}
