import { expect, test } from "vitest";

import { areaOf, displaced, fading, neighboursOf, ring, sharesAtPlace, sharesInRegion } from "../src/geometry/edit-preview";
import type { Vec3 } from "../src/geometry/vectors";

/** A flat square of n by n vertices, one millimetre apart. */
function sheet(n: number): [Float32Array, Uint32Array] {
  const positions: number[] = [];
  const indices: number[] = [];
  for (let y = 0; y < n; y++) for (let x = 0; x < n; x++) positions.push(x, y, 0);
  for (let y = 0; y + 1 < n; y++)
    for (let x = 0; x + 1 < n; x++) {
      const a = y * n + x;
      indices.push(a, a + 1, a + n + 1, a, a + n + 1, a + n);
    }
  return [Float32Array.from(positions), Uint32Array.from(indices)];
}

test("the fade is level at both ends and a half in the middle", () => {
  expect(fading(0)).toBe(1);
  expect(fading(1)).toBe(0);
  expect(fading(0.5)).toBeCloseTo(0.5, 12);
  expect(1 - fading(0.01)).toBeLessThan(2e-5);
  expect(fading(0.99)).toBeLessThan(2e-5);
});

test("at a place the share is whole on the flat part and nothing beyond the soft edge", () => {
  const [positions, indices] = sheet(61);
  const near = neighboursOf(61 * 61, indices);
  const found = sharesAtPlace(positions, near, 30 * 61 + 30, [30, 30, 0], 4, 12);
  const share = new Map([...found.vertices].map((v, i) => [v, found.shares[i]]));
  expect(share.get(30 * 61 + 30)).toBe(1);
  expect(share.get(30 * 61 + 34)).toBe(1);
  expect(share.get(30 * 61 + 40)).toBeCloseTo(fading(0.5), 6);
  expect(share.has(30 * 61 + 47)).toBe(false);
});

test("a region fades inwards and leaves alone what lies outside", () => {
  const [positions, indices] = sheet(61);
  const near = neighboursOf(61 * 61, indices);
  const line: Vec3[] = Array.from({ length: 48 }, (_, i) => {
    const a = (2 * Math.PI * i) / 48;
    return [30 + 20 * Math.cos(a), 30 + 20 * Math.sin(a), 0];
  });
  const found = sharesInRegion(positions, near, line, 30 * 61 + 30, 10);
  const share = new Map([...found.vertices].map((v, i) => [v, found.shares[i]]));
  expect(share.get(30 * 61 + 30)).toBe(1);
  expect(share.get(30 * 61 + 45)).toBeGreaterThan(0.3);
  expect(share.get(30 * 61 + 45)).toBeLessThan(0.7);
  expect(share.has(30 * 61 + 52)).toBe(false);
});

test("a drawn line knows its inside, its middle and the distance to it", () => {
  const square: Vec3[] = [
    [0, 0, 5],
    [10, 0, 5],
    [10, 10, 5],
    [0, 10, 5],
  ];
  const made = ring(square);
  expect(made.isInside([5, 5, 5])).toBe(true);
  expect(made.isInside([5, 11, 5])).toBe(false);
  expect(made.distance([5, 4, 5])).toBeCloseTo(4, 12);
});

test("the area of an edit is that of its triangles, each by the share of its corners", () => {
  const [positions, indices] = sheet(11);
  const vertices = Uint32Array.from({ length: 121 }, (_, v) => v);
  const whole = { vertices, shares: new Float32Array(121).fill(1) };
  const sloping = { vertices, shares: Float32Array.from(vertices, (v) => (v % 11) / 10) };
  expect(areaOf(positions, indices, whole)).toBeCloseTo(100, 9);
  expect(areaOf(positions, indices, sloping)).toBeCloseTo(50, 5);
  // One inner vertex of a grid: a third of the six triangles round it.
  expect(areaOf(positions, indices, { vertices: Uint32Array.of(60), shares: Float32Array.of(1) })).toBeCloseTo(1, 9);
});

test("an edit moves its vertices along their normals, and their differences by as much", () => {
  const [positions] = sheet(3);
  const normals = Float32Array.from({ length: 27 }, (_, i) => (i % 3 === 2 ? 1 : 0));
  const differences_mm = new Float32Array(9).fill(0.25);
  const moved = displaced({ positions, normals, differences_mm }, { vertices: Uint32Array.of(4, 8), shares: Float32Array.of(1, 0.5) }, -2);
  expect([...moved.positions]).toEqual([1, 1, -2, 2, 2, -1]);
  expect([...moved.differences_mm]).toEqual([0.25, 0.25, 0.25, 0.25, -1.75, 0.25, 0.25, 0.25, -0.75]);
  expect(differences_mm[4]).toBe(0.25); // what was known stays
});
