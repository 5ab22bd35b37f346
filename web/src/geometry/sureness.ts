/** How much of a surface was measured, how sure it is, and where it is least sure. */
import { type Vec3, cross, sub, triple, unit } from "./vectors";

/** A surface with one sigma in mm for each vertex; where it is not finite, or `filled` says so, nothing was measured. */
interface Measured {
  readonly positions: Float32Array;
  readonly indices: Uint32Array;
  readonly sigma: Float32Array | null;
  readonly filled: Uint8Array | null;
}

export interface Sureness {
  /** Of the vertices, those that were measured. */
  readonly share: number;
  /** Two sigma that half of the surface keeps, mm. */
  readonly typical: number;
  readonly worst_mm: number;
  readonly where: Vec3;
  readonly normal: Vec3;
}

/** Of all vertices; beyond four times its sigma a triangle is no doubt to act on. */
const ALMOST_ALL = 0.998;

/** Null where nothing was measured. */
export function surenessOf(data: Measured): Sureness | null {
  const { sigma, filled } = data;
  if (!sigma) return null;
  const kept = sigma.filter((s, i) => Number.isFinite(s) && !filled?.[i]).sort();
  if (!kept.length) return null;
  const { face, sigma_mm } = leastSure(data.indices, sigma, 4 * kept[Math.floor(ALMOST_ALL * (kept.length - 1))]);
  const corner = (k: number): Vec3 => triple(data.positions, data.indices[face + k]);
  return {
    share: 1 - (sigma.length - kept.length) / sigma.length,
    typical: 2 * kept[Math.floor(kept.length / 2)],
    worst_mm: 2 * sigma_mm,
    where: face < 0 ? [0, 0, 0] : corner(0),
    normal: face < 0 ? [0, 0, 1] : unit(cross(sub(corner(1), corner(0)), sub(corner(2), corner(0)))),
  };
}

/** The triangle whose surest corner is least sure, within a limit: single corners are no doubt to act on. -1 where there is none. */
function leastSure(indices: Uint32Array, sigma: Float32Array, limit_mm: number): { face: number; sigma_mm: number } {
  let face = -1;
  let worst = 0;
  for (let f = 0; f < indices.length; f += 3) {
    const low = Math.min(sigma[indices[f]], sigma[indices[f + 1]], sigma[indices[f + 2]]);
    if (Number.isFinite(low) && low > worst && low <= limit_mm) [worst, face] = [low, f];
  }
  return { face, sigma_mm: worst };
}
