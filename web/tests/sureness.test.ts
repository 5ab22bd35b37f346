import { expect, test } from "vitest";

import { surenessOf } from "../src/geometry/sureness";

/** A strip of triangles in the plane z = 0, its normal up: vertex v lies at (floor(v / 2), v % 2). */
function strip(sigma: readonly number[]) {
  const positions = Float32Array.from(sigma.flatMap((_, v) => [Math.floor(v / 2), v % 2, 0]));
  const indices: number[] = [];
  for (let v = 0; v + 2 < sigma.length; v++) indices.push(...(v % 2 ? [v, v + 1, v + 2] : [v, v + 2, v + 1]));
  return { positions, indices: Uint32Array.from(indices), sigma: Float32Array.from(sigma), filled: null as Uint8Array | null };
}

test("half of the surface keeps to twice the middle sigma; the least sure triangle is told by its surest corner", () => {
  const found = surenessOf(strip([0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.1, 0.1]));
  expect(found?.share).toBe(1);
  expect(found?.typical).toBeCloseTo(0.2, 6);
  expect(found?.worst_mm).toBeCloseTo(0.4, 6);
  expect(found?.where[0]).toBeGreaterThanOrEqual(1);
  expect(found?.where[0]).toBeLessThanOrEqual(2);
  expect(Math.abs(found?.normal[2] ?? 0)).toBe(1);
});

test("what is filled or has no sigma counts as not measured", () => {
  const data = strip([0.1, 0.1, NaN, 0.1, 0.1, 0.1, 0.1, 0.1]);
  data.filled = Uint8Array.of(1, 0, 0, 0, 0, 0, 0, 0);
  expect(surenessOf(data)?.share).toBeCloseTo(0.75, 12);
});

test("a single corner that is unsure is no doubt to act on", () => {
  expect(surenessOf(strip([0.1, 0.1, 0.1, 5, 0.1, 0.1, 0.1, 0.1]))?.worst_mm).toBeCloseTo(0.2, 6);
});

test("without sigma nothing is told", () => {
  expect(surenessOf({ ...strip([0.1, 0.1, 0.1]), sigma: null })).toBeNull();
  expect(surenessOf(strip([NaN, NaN, NaN]))).toBeNull();
});
