/**
 * The preview of a load or a relief while its depth is dragged.
 *
 * In      the mesh, its normals, a place or a drawn region, depth, soft edge.
 * Out     how far each vertex near it moves along its normal: share of the depth, 0 to 1.
 * Method  distance from the place over the surface, by Dijkstra along edges, or straight to the
 *         region's outline; the share fades as the library's edit does: level at both ends.
 *
 * The server replays the recipe and is the truth; this only follows the hand until it answers.
 */
import { type Vec3, add, cross, distance, dot, length, sub, triple, unit } from "./vectors";

/** A region of more vertices is not previewed: the server tries it. */
const MOST_INSIDE = 60_000;

/** From 1 at 0 to 0 at 1, level and without bend at both ends. */
export function fading(share: number): number {
  const x = Math.min(1, Math.max(0, share));
  return 1 - x * x * x * (10 + x * (6 * x - 15));
}

export interface Neighbours {
  readonly start: Uint32Array;
  readonly next: Uint32Array;
}

/** Which vertices an edge joins to which: those of vertex i are next[start[i]] to next[start[i + 1]]. */
export function neighboursOf(count: number, indices: Uint32Array): Neighbours {
  const degree = new Uint32Array(count + 1);
  for (let f = 0; f < indices.length; f++) degree[indices[f] + 1] += 2;
  for (let i = 0; i < count; i++) degree[i + 1] += degree[i];
  const start = degree.slice();
  const fill = degree.slice();
  const next = new Uint32Array(start[count]);
  for (let f = 0; f < indices.length; f += 3)
    for (let k = 0; k < 3; k++) {
      const v = indices[f + k];
      next[fill[v]++] = indices[f + ((k + 1) % 3)];
      next[fill[v]++] = indices[f + ((k + 2) % 3)];
    }
  return { start, next };
}

export interface Shares {
  readonly vertices: Uint32Array;
  readonly shares: Float32Array;
}

export function sharesAtPlace(positions: Float32Array, near: Neighbours, seed: number, place: Vec3, flat_mm: number, falloff_mm: number): Shares {
  const reach = flat_mm + falloff_mm;
  const found = spread(positions, near, new Map([[seed, distance(triple(positions, seed), place)]]), reach);
  return shared(found, (d) => fading((d - flat_mm) / falloff_mm));
}

/**
 * Shares inside a closed line drawn on the surface, fading inwards from it.
 *
 * The inside is what can be reached from `seed` without crossing the line; vertices nearer to the
 * line than about an edge bound the walk.
 */
export function sharesInRegion(positions: Float32Array, near: Neighbours, line: readonly Vec3[], seed: number, falloff_mm: number): Shares {
  const rim = ring(line);
  const inside = new Set<number>([seed]);
  const queue = [seed];
  while (queue.length && inside.size < MOST_INSIDE) {
    const v = queue.pop() as number;
    for (let k = near.start[v]; k < near.start[v + 1]; k++) {
      const w = near.next[k];
      if (inside.has(w) || !rim.isInside(triple(positions, w))) continue;
      inside.add(w);
      queue.push(w);
    }
  }
  if (inside.size >= MOST_INSIDE) return { vertices: new Uint32Array(), shares: new Float32Array() };
  const found = new Map<number, number>();
  for (const v of inside) found.set(v, rim.distance(triple(positions, v)));
  return shared(found, (d) => 1 - fading(d / falloff_mm));
}

/** A surface as it is known before an edit: flat arrays of x, y, z in mm; differences in mm for each vertex. */
export interface Ground {
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  readonly differences_mm: Float32Array;
}

/** Where the vertices of an edit come to lie, three numbers each in their order, and the differences of all vertices then. */
export function displaced(ground: Ground, { vertices, shares }: Shares, outward_mm: number): Omit<Ground, "normals"> {
  const positions = new Float32Array(3 * vertices.length);
  const differences_mm = ground.differences_mm.slice();
  for (let i = 0; i < vertices.length; i++) {
    const by = outward_mm * shares[i];
    const k = 3 * vertices[i];
    for (let c = 0; c < 3; c++) positions[3 * i + c] = ground.positions[k + c] + by * ground.normals[k + c];
    differences_mm[vertices[i]] += by;
  }
  return { positions, differences_mm };
}

/** Sum of share times area over the vertices moved, mm2: times depth it is the volume of the edit. */
export function areaOf(positions: Float32Array, indices: Uint32Array, { vertices, shares }: Shares): number {
  const share = new Map<number, number>();
  vertices.forEach((v, i) => share.set(v, shares[i]));
  let sum = 0;
  for (let f = 0; f < indices.length; f += 3) {
    const [a, b, c] = [indices[f], indices[f + 1], indices[f + 2]];
    const part = (share.get(a) ?? 0) + (share.get(b) ?? 0) + (share.get(c) ?? 0);
    if (!part) continue;
    const corner = triple(positions, a);
    sum += (part / 6) * length(cross(sub(triple(positions, b), corner), sub(triple(positions, c), corner)));
  }
  return sum;
}

/** A closed line that lies on a surface: what is inside it, and how far something is from it. */
export function ring(line: readonly Vec3[]) {
  const count = line.length;
  const centre = line.reduce<Vec3>((s, p) => [s[0] + p[0] / count, s[1] + p[1] / count, s[2] + p[2] / count], [0, 0, 0]);
  // Newell's normal of the line: the plane on which inside and outside are told apart.
  let normal: Vec3 = [0, 0, 0];
  for (let i = 0; i < count; i++) {
    normal = add(normal, cross(sub(line[i], centre), sub(line[(i + 1) % count], centre)));
  }
  normal = unit(normal);
  const helper: Vec3 = Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const ux = unit(cross(helper, normal));
  const uy = cross(normal, ux);
  const flat = line.map((p) => {
    const d = sub(p, centre);
    return [dot(d, ux), dot(d, uy)] as const;
  });
  const inPlane = (x: number, y: number) => {
    let odd = false;
    for (let i = 0, j = count - 1; i < count; j = i++) {
      const [xi, yi] = flat[i];
      const [xj, yj] = flat[j];
      if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) odd = !odd;
    }
    return odd;
  };
  const reach = Math.max(...line.map((p) => Math.hypot(...sub(p, centre)))) * 1.05;
  const isInside = (p: Vec3) => {
    const d = sub(p, centre);
    return Math.hypot(...d) <= reach && inPlane(dot(d, ux), dot(d, uy));
  };
  return {
    centre,
    isInside,
    distance: (p: Vec3) => {
      let best = Infinity;
      for (let i = 0; i < count; i++) best = Math.min(best, toSegment(p, line[i], line[(i + 1) % count]));
      return best;
    },
  };
}

function toSegment(p: Vec3, a: Vec3, b: Vec3): number {
  const ab = sub(b, a);
  const ap = sub(p, a);
  const s = Math.min(1, Math.max(0, dot(ap, ab) / (dot(ab, ab) || 1)));
  return Math.hypot(ap[0] - s * ab[0], ap[1] - s * ab[1], ap[2] - s * ab[2]);
}

function shared(found: Map<number, number>, share: (distance: number) => number): Shares {
  const vertices: number[] = [];
  const shares: number[] = [];
  for (const [v, d] of found) {
    const s = share(d);
    if (s > 0) {
      vertices.push(v);
      shares.push(s);
    }
  }
  return { vertices: Uint32Array.from(vertices), shares: Float32Array.from(shares) };
}

/** Shortest ways along edges from some vertices, up to a reach. A binary heap of pairs. */
function spread(positions: Float32Array, near: Neighbours, from: Map<number, number>, reach: number): Map<number, number> {
  const done = new Map<number, number>();
  const heap: [number, number][] = [];
  const push = (d: number, v: number) => {
    heap.push([d, v]);
    for (let i = heap.length - 1; i > 0;) {
      const up = (i - 1) >> 1;
      if (heap[up][0] <= heap[i][0]) break;
      [heap[up], heap[i]] = [heap[i], heap[up]];
      i = up;
    }
  };
  const pop = () => {
    const top = heap[0];
    const last = heap.pop() as [number, number];
    if (heap.length) {
      heap[0] = last;
      for (let i = 0; ;) {
        const l = 2 * i + 1;
        if (l >= heap.length) break;
        const small = l + 1 < heap.length && heap[l + 1][0] < heap[l][0] ? l + 1 : l;
        if (heap[i][0] <= heap[small][0]) break;
        [heap[small], heap[i]] = [heap[i], heap[small]];
        i = small;
      }
    }
    return top;
  };
  for (const [v, d] of from) push(d, v);
  while (heap.length) {
    const [d, v] = pop();
    if (done.has(v) || d > reach) continue;
    done.set(v, d);
    for (let k = near.start[v]; k < near.start[v + 1]; k++) {
      const w = near.next[k];
      if (done.has(w)) continue;
      const step = Math.hypot(positions[3 * v] - positions[3 * w], positions[3 * v + 1] - positions[3 * w + 1], positions[3 * v + 2] - positions[3 * w + 2]);
      if (d + step <= reach) push(d + step, w);
    }
  }
  return done;
}
