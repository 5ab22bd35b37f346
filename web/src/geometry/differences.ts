/** How far a surface that was changed lies from what its colours are held against. */
import { Vector3 } from "three";

import { triple } from "./vectors";

/** The surface before the change. */
export interface Before {
  readonly positions: Float32Array;
  /** For each of its vertices, mm. */
  readonly differences_mm: Float32Array;
  /** What measures to it, outward positive; null where nothing is drawn. */
  readonly surface: { signedDistance(point: Vector3): { readonly signed_mm: number; readonly vertex: number } } | null;
}

/**
 * A difference in mm for each vertex after a change.
 *
 * A vertex that stayed keeps its own; another one has that of the nearest place before, and its distance to that.
 */
export function changedDifferences(positions: Float32Array, before: Before): Float32Array {
  const count = positions.length / 3;
  const old = before.positions;
  const values = new Float32Array(count);
  const p = new Vector3();
  for (let i = 0, k = 0; i < count; i++, k += 3) {
    const same = k < old.length && positions[k] === old[k] && positions[k + 1] === old[k + 1] && positions[k + 2] === old[k + 2];
    if (same) values[i] = before.differences_mm[i];
    else if (before.surface) {
      const found = before.surface.signedDistance(p.set(...triple(positions, i)));
      values[i] = (before.differences_mm[found.vertex] ?? 0) + found.signed_mm;
    }
  }
  return values;
}
