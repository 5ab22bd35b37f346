import { expect, test } from "vitest";

import { guessFrame } from "../src/geometry/guess";
import { apply, cross, dot } from "../src/geometry/vectors";

/** A cup: closed at `tip`, open at the other end, its axis along a tilted direction. */
function cup(): [Float32Array, Uint32Array] {
  const positions: number[] = [0, 0, 0];
  const indices: number[] = [];
  const rows = 30;
  const around = 40;
  for (let j = 1; j <= rows; j++)
    for (let i = 0; i < around; i++) {
      const a = (2 * Math.PI * i) / around;
      const r = 45 * Math.sqrt(Math.min(1, j / 6));
      positions.push(r * Math.cos(a), r * Math.sin(a), (240 * j) / rows);
    }
  for (let i = 0; i < around; i++) indices.push(0, 1 + ((i + 1) % around), 1 + i);
  for (let j = 0; j + 1 < rows; j++)
    for (let i = 0; i < around; i++) {
      const k = (i + 1) % around;
      const [a, b, c, d] = [1 + j * around + i, 1 + j * around + k, 1 + (j + 1) * around + i, 1 + (j + 1) * around + k];
      indices.push(a, b, d, a, d, c);
    }
  return [Float32Array.from(positions), Uint32Array.from(indices)];
}

test("the open end is proximal, whichever way the limb stands", () => {
  const [positions, indices] = cup();
  const upright = guessFrame(positions, indices);
  expect(upright.rotation[2][2]).toBeGreaterThan(0.99);
  const headDown = positions.map((v, i) => (i % 3 === 2 ? 300 - v : i % 3 === 0 ? -v : v));
  const turned = guessFrame(headDown, indices);
  expect(turned.rotation[2][2]).toBeLessThan(-0.99);
  expect(apply(turned, [0, 0, 300])[2]).toBeCloseTo(0, 3);
});

test("the frame is a rotation", () => {
  const [positions, indices] = cup();
  const frame = guessFrame(positions, indices, [1, 1, 0]);
  const [x, y, z] = frame.rotation;
  expect(dot(cross(x, y), z)).toBeCloseTo(1, 9);
  for (const axis of frame.rotation) expect(dot(axis, axis)).toBeCloseTo(1, 9);
});
