/** Small vectors and rigid motions. Arrays of three numbers; a motion is x' = R x + t, R by rows. */

export type Vec3 = readonly [number, number, number];

export interface Rigid {
  readonly rotation: readonly [Vec3, Vec3, Vec3];
  readonly translation: Vec3;
}

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vec3, s: number): Vec3 => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vec3, b: Vec3): Vec3 => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);
export const unit = (a: Vec3): Vec3 => {
  const size = length(a);
  return size > 0 ? scale(a, 1 / size) : [0, 0, 1];
};
export const distance = (a: Vec3, b: Vec3): number => length(sub(a, b));

export const apply = (m: Rigid, p: Vec3): Vec3 => [
  dot(m.rotation[0], p) + m.translation[0],
  dot(m.rotation[1], p) + m.translation[1],
  dot(m.rotation[2], p) + m.translation[2],
];

export const IDENTITY: Rigid = {
  rotation: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  translation: [0, 0, 0],
};

/** A motion as the sixteen numbers of a matrix by columns, as three.js takes it. */
export const columns = (m: Rigid): number[] => {
  const [a, b, c] = m.rotation;
  return [a[0], b[0], c[0], 0, a[1], b[1], c[1], 0, a[2], b[2], c[2], 0, ...m.translation, 1];
};

/** Three numbers of an answer as a vector. */
export const vec3 = (values: readonly number[]): Vec3 => [values[0], values[1], values[2]];

/** A point of the canvas as three numbers. */
export const xyz = (p: { readonly x: number; readonly y: number; readonly z: number }): Vec3 => [p.x, p.y, p.z];

/** The k-th triple of a flat array: a vertex, or its normal. */
export const triple = (flat: Float32Array, k: number): Vec3 => [flat[3 * k], flat[3 * k + 1], flat[3 * k + 2]];
