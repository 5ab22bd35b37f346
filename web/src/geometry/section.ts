/**
 * Sections across the long axis: where a plane at one height cuts the surface.
 *
 * In      vertices (x, y, z in mm) and triangles, and a motion into the frame whose z is the axis.
 * Out     closed or open polylines at that height, and what a tape round one limb would read: round the
 *         loop that the axis goes through, or the nearest to it; of a wall's inside, round its hollow.
 * Method  each triangle that crosses gives one segment between two cut edges; segments that share
 *         an edge are joined. The outline is smoothed over 5 mm, as the server's is: by the kernel
 *         of 1 / (1 + (k l)^4). The tape lies on the convex hull of that (Andrew's monotone chain).
 *
 * The server measures the figures that are kept. This one follows the hand while a level is dragged.
 */
import figures from "../api/figures.json";
import { IDENTITY, type Rigid, type Vec3, apply } from "./vectors";

export interface Section {
  readonly height_mm: number;
  readonly loops: readonly (readonly Vec3[])[];
  /** Length of the convex hull of the limb's smoothed loop: a taut tape. NaN where nothing closes. */
  readonly tape_mm: number;
  /** Length of the smoothed loop itself. */
  readonly contour_mm: number;
  readonly area_mm2: number;
}

/** What of a shape is measured: its outline, or the largest hollow in that, as the limb in a wall is. */
export type Skin = "outline" | "hollow";

export function heightsOf(positions: Float32Array, frame: Rigid = IDENTITY): Float32Array {
  const [x, y, z] = frame.rotation[2];
  const t = frame.translation[2];
  const heights = new Float32Array(positions.length / 3);
  for (let i = 0, k = 0; i < heights.length; i++, k += 3) heights[i] = x * positions[k] + y * positions[k + 1] + z * positions[k + 2] + t;
  return heights;
}

export function cut(
  positions: Float32Array,
  indices: Uint32Array,
  heights: Float32Array,
  height_mm: number,
  frame: Rigid = IDENTITY,
  skin: Skin = "outline",
): Section {
  const points = new Map<number, Vec3>();
  const ends = new Map<number, number[]>();
  const n = heights.length;
  const on = (i: number, j: number): number => {
    const [a, b] = i < j ? [i, j] : [j, i];
    const key = a * n + b;
    if (!points.has(key)) {
      const s = (height_mm - heights[a]) / (heights[b] - heights[a]);
      const at = (k: number) => positions[3 * a + k] + s * (positions[3 * b + k] - positions[3 * a + k]);
      points.set(key, apply(frame, [at(0), at(1), at(2)]));
    }
    return key;
  };
  const join = (p: number, q: number) => {
    if (p === q) return;
    for (const [from, to] of [
      [p, q],
      [q, p],
    ]) {
      const known = ends.get(from);
      if (known) known.push(to);
      else ends.set(from, [to]);
    }
  };
  for (let f = 0; f < indices.length; f += 3) {
    const a = indices[f];
    const b = indices[f + 1];
    const c = indices[f + 2];
    const above = (heights[a] >= height_mm ? 1 : 0) + (heights[b] >= height_mm ? 2 : 0) + (heights[c] >= height_mm ? 4 : 0);
    if (above === 0 || above === 7) continue;
    const lone = above === 1 || above === 6 ? 0 : above === 2 || above === 5 ? 1 : 2;
    const [i, j, k] = lone === 0 ? [a, b, c] : lone === 1 ? [b, c, a] : [c, a, b];
    join(on(i, j), on(i, k));
  }
  const loops = chains(ends).map((chain) => chain.map((key) => points.get(key) as Vec3));
  const closed = loops.filter((loop) => loop.length > 3 && same(loop[0], loop[loop.length - 1]));
  const outline = onAxis(closed);
  const limb = skin === "hollow" && outline ? hollowIn(outline, closed) : outline;
  const smooth = limb ? smoothed(limb) : [];
  return {
    height_mm,
    loops,
    tape_mm: limb ? around(hull(smooth)) : NaN,
    contour_mm: limb ? around(smooth) : NaN,
    area_mm2: limb ? Math.abs(areaOf(limb)) : NaN,
  };
}

/** The loop that the line x = y = 0 goes through, the outermost of several; else the nearest. */
function onAxis(loops: readonly (readonly Vec3[])[]): readonly Vec3[] | null {
  let best: readonly Vec3[] | null = null;
  let [held, size] = [false, 0];
  for (const loop of loops) {
    const round = holds(loop, 0, 0);
    const fit = round ? Math.abs(areaOf(loop)) : -Math.min(...loop.map((p) => Math.hypot(p[0], p[1])));
    if (!best || (round && !held) || (round === held && fit > size)) [best, held, size] = [loop, round, fit];
  }
  return best;
}

/** The largest loop in an outline; a smaller one than a limb could fill is a hole for a screw. */
function hollowIn(outline: readonly Vec3[], loops: readonly (readonly Vec3[])[]): readonly Vec3[] | null {
  let best: readonly Vec3[] | null = null;
  let size = HOLLOW_SHARE * Math.abs(areaOf(outline));
  for (const loop of loops) {
    const area = Math.abs(areaOf(loop));
    if (loop !== outline && area > size && holds(outline, loop[0][0], loop[0][1])) [best, size] = [loop, area];
  }
  return best;
}

/** Whether a loop goes round a place: a ray to +x crosses it an odd number of times. */
function holds(loop: readonly Vec3[], x: number, y: number): boolean {
  let inside = false;
  for (let i = 1; i < loop.length; i++) {
    const [a, b] = [loop[i - 1], loop[i]];
    if (a[1] > y !== b[1] > y && a[0] - ((a[1] - y) * (b[0] - a[0])) / (b[1] - a[1]) > x) inside = !inside;
  }
  return inside;
}

const { SMOOTHING_MM, HOLLOW_SHARE } = figures;
const EVEN_STEPS = 16;

/** A closed line (its first point repeated) at even steps through the spline filter. */
function smoothed(loop: readonly Vec3[]): Vec3[] {
  const whole = lengthOf(loop);
  const count = Math.max(EVEN_STEPS, Math.ceil((whole * EVEN_STEPS) / SMOOTHING_MM));
  const step = whole / count;
  const even: Vec3[] = [];
  let walked = 0;
  for (let i = 1; i < loop.length; i++) {
    const [a, b] = [loop[i - 1], loop[i]];
    const piece = flat(a, b);
    for (; even.length < count && even.length * step < walked + piece;) {
      const s = (even.length * step - walked) / piece;
      even.push([a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2]]);
    }
    walked += piece;
  }
  const n = even.length;
  const reach = Math.min(Math.ceil((2 * SMOOTHING_MM) / step), Math.floor((n - 1) / 2));
  const fade = (Math.SQRT2 * Math.PI * step) / SMOOTHING_MM;
  const kernel = Array.from({ length: reach + 1 }, (_, k) => Math.exp(-k * fade) * Math.sin(k * fade + Math.PI / 4));
  const total = kernel.reduce((sum, part, k) => sum + (k ? 2 * part : part), 0);
  return even.map((_, i): Vec3 => {
    let [x, y] = [0, 0];
    for (let k = -reach; k <= reach; k++) {
      const p = even[(((i + k) % n) + n) % n];
      x += kernel[Math.abs(k)] * p[0];
      y += kernel[Math.abs(k)] * p[1];
    }
    return [x / total, y / total, even[i][2]];
  });
}

/** The convex hull in x and y, counter-clockwise, the first point not repeated. */
export function hull(points: readonly Vec3[]): Vec3[] {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (from: readonly Vec3[]) => {
    const line: Vec3[] = [];
    for (const p of from) {
      while (line.length > 1 && turn(line[line.length - 2], line[line.length - 1], p) <= 0) line.pop();
      line.push(p);
    }
    line.pop();
    return line;
  };
  return [...half(sorted), ...half([...sorted].reverse())];
}

const turn = (o: Vec3, a: Vec3, b: Vec3) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
const same = (a: Vec3, b: Vec3) => a[0] === b[0] && a[1] === b[1] && a[2] === b[2];
const flat = (a: Vec3, b: Vec3) => Math.hypot(a[0] - b[0], a[1] - b[1]);

function around(ring: readonly Vec3[]): number {
  return ring.reduce((sum, p, i) => sum + flat(p, ring[(i + 1) % ring.length]), 0);
}

function lengthOf(line: readonly Vec3[]): number {
  let sum = 0;
  for (let i = 1; i < line.length; i++) sum += flat(line[i - 1], line[i]);
  return sum;
}

function areaOf(loop: readonly Vec3[]): number {
  let sum = 0;
  for (let i = 1; i < loop.length; i++) sum += loop[i - 1][0] * loop[i][1] - loop[i][0] * loop[i - 1][1];
  return sum / 2;
}

/** Keys joined into lines; a closed one repeats its first key at its end. */
function chains(ends: Map<number, number[]>): number[][] {
  const used = new Set<number>();
  const found: number[][] = [];
  const walk = (start: number) => {
    const line = [start];
    used.add(start);
    let here = start;
    for (;;) {
      const onward: number | undefined = (ends.get(here) as number[]).find((key) => !used.has(key));
      if (onward === undefined) break;
      used.add(onward);
      line.push(onward);
      here = onward;
    }
    if (line.length > 2 && (ends.get(here) as number[]).includes(start)) line.push(start);
    return line;
  };
  for (const [key, near] of ends) if (!used.has(key) && near.length === 1) found.push(walk(key));
  for (const key of ends.keys()) if (!used.has(key)) found.push(walk(key));
  return found;
}
