/**
 * Axes turned by hand: what the handles of the limb did to its frame.
 *
 * Positive takes the front towards the patient's left (turn), the proximal end backwards (flex), and
 * the proximal end towards the patient's right (lean); in degrees, about the axes as they were set.
 */
import { type Rigid, type Vec3, dot } from "./vectors";

export interface AxesTurn {
  readonly turn_deg: number;
  readonly flex_deg: number;
  readonly lean_deg: number;
}

export const STILL: AxesTurn = { turn_deg: 0, flex_deg: 0, lean_deg: 0 };

export const isStill = (by: AxesTurn) => by.turn_deg === 0 && by.flex_deg === 0 && by.lean_deg === 0;

/** The frame after the hand: first leaned, then flexed, then turned about the long axis. */
export function turned(frame: Rigid, by: AxesTurn): Rigid {
  const q = rotationOf(by);
  const [a, b, c] = frame.rotation;
  const columns: readonly Vec3[] = [0, 1, 2].map((k): Vec3 => [a[k], b[k], c[k]]);
  const row = (r: Vec3): Vec3 => [dot(r, columns[0]), dot(r, columns[1]), dot(r, columns[2])];
  const t = frame.translation;
  return { rotation: [row(q[0]), row(q[1]), row(q[2])], translation: [dot(q[0], t), dot(q[1], t), dot(q[2], t)] };
}

function rotationOf({ turn_deg, flex_deg, lean_deg }: AxesTurn): readonly [Vec3, Vec3, Vec3] {
  const [ct, st] = sweep(turn_deg);
  const [cf, sf] = sweep(flex_deg);
  const [cl, sl] = sweep(lean_deg);
  // Flexed after leaned, rows of the product.
  const m: readonly [Vec3, Vec3, Vec3] = [
    [cl, 0, sl],
    [sf * sl, cf, -sf * cl],
    [-cf * sl, sf, cf * cl],
  ];
  const mixed = (p: number, q: number): Vec3 => [p * m[0][0] + q * m[1][0], p * m[0][1] + q * m[1][1], p * m[0][2] + q * m[1][2]];
  return [mixed(ct, -st), mixed(st, ct), m[2]];
}

const sweep = (deg: number): readonly [number, number] => [Math.cos((deg * Math.PI) / 180), Math.sin((deg * Math.PI) / 180)];
