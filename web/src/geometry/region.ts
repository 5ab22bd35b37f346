/**
 * A closed line that a hand drew on the surface.
 *
 * In      the points over which the hand went.
 * Out     the line as it is sent: few points, none on its neighbour; and the vertex in the middle of it.
 */
import { ring } from "./edit-preview";
import { type Pixel } from "./nearest";
import { type Vec3, distance, triple } from "./vectors";

const APART_MM = 1;
const MOST_POINTS = 48;
/** To so many points before and after, the direction of a stroke is taken. */
const AROUND = 2;

/** So many points of a line that it can be sent, evenly left out. */
export function thinned<P>(points: readonly P[], most = MOST_POINTS): P[] {
  const step = Math.max(1, Math.ceil(points.length / most));
  return points.filter((_, i) => i % step === 0);
}

/** A line without points that lie on their neighbour; a hand closes a line where it began. */
export function apart(line: readonly Vec3[]): Vec3[] {
  const kept: Vec3[] = [];
  for (const p of line) if (!kept.length || distance(kept[kept.length - 1], p) > APART_MM) kept.push(p);
  while (kept.length > 1 && distance(kept[0], kept[kept.length - 1]) <= APART_MM) kept.pop();
  return kept;
}

export interface Middle {
  readonly seed: number;
  readonly anchor: Vec3;
  /** To the line, mm. */
  readonly reach_mm: number;
}

/** The vertex inside a closed line that is nearest to its centre; null where no vertex is inside. */
export function middleOf(line: readonly Vec3[], positions: Float32Array): Middle | null {
  if (line.length < 4) return null;
  const area = ring(line);
  let seed = -1;
  let least = Infinity;
  for (let v = 0; v < positions.length / 3; v++) {
    const p = triple(positions, v);
    const gap = distance(p, area.centre);
    if (gap < least && area.isInside(p)) [seed, least] = [v, gap];
  }
  if (seed < 0) return null;
  const anchor = triple(positions, seed);
  return { seed, anchor, reach_mm: area.distance(anchor) };
}

/** The outline of a stroke on the page: along its one side, and back along the other. */
export function outlineOf(stroke: readonly { readonly x: number; readonly y: number }[], half_px: number): Pixel[] {
  const side = (way: number) =>
    stroke.map((p, i): Pixel => {
      const a = stroke[Math.max(0, i - AROUND)];
      const b = stroke[Math.min(stroke.length - 1, i + AROUND)];
      const far = Math.hypot(b.x - a.x, b.y - a.y) || 1;
      return [p.x - (way * half_px * (b.y - a.y)) / far, p.y + (way * half_px * (b.x - a.x)) / far];
    });
  return [...side(1), ...side(-1).reverse()];
}
