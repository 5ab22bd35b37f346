import { expect, test } from "vitest";

import { apart, middleOf, outlineOf, thinned } from "../src/geometry/region";
import type { Vec3 } from "../src/geometry/vectors";

/** A flat square of n by n vertices, one millimetre apart. */
const sheet = (n: number) => Float32Array.from({ length: 3 * n * n }, (_, i) => [Math.floor(i / 3) % n, Math.floor(i / 3 / n), 0][i % 3]);

const circle = (count: number, radius: number): Vec3[] =>
  Array.from({ length: count }, (_, i) => [20 + radius * Math.cos((2 * Math.PI * i) / count), 20 + radius * Math.sin((2 * Math.PI * i) / count), 0]);

test("a line is sent with few points, evenly left out, and beginning where it began", () => {
  const all = Array.from({ length: 100 }, (_, i) => i);
  expect(thinned(all, 48)).toEqual(all.filter((i) => i % 3 === 0));
  expect(thinned(all.slice(0, 48), 48)).toHaveLength(48);
});

test("points on their neighbour are left out, also where the line closes", () => {
  const line: Vec3[] = [
    [0, 0, 0],
    [0.5, 0, 0],
    [3, 0, 0],
    [3, 3, 0],
    [3, 3.9, 0],
    [0.4, 0.4, 0],
  ];
  expect(apart(line)).toEqual([
    [0, 0, 0],
    [3, 0, 0],
    [3, 3, 0],
  ]);
});

test("the middle of a circle is its centre, as far from the line as its radius", () => {
  const middle = middleOf(circle(64, 15), sheet(41));
  expect(middle?.seed).toBe(20 * 41 + 20);
  expect(middle?.anchor).toEqual([20, 20, 0]);
  expect(middle?.reach_mm).toBeGreaterThan(15 * Math.cos(Math.PI / 64) - 1e-6);
  expect(middle?.reach_mm).toBeLessThan(15);
});

test("the middle lies inside the line, also where the centre does not", () => {
  const hook: Vec3[] = [
    [-0.5, -0.5, 0],
    [30.5, -0.5, 0],
    [30.5, 4.5, 0],
    [4.5, 4.5, 0],
    [4.5, 30.5, 0],
    [-0.5, 30.5, 0],
  ];
  const middle = middleOf(hook, sheet(41));
  const [x, y] = middle?.anchor ?? [Infinity, Infinity];
  expect(Math.min(x, y)).toBeLessThan(4.5);
  expect(Math.max(x, y)).toBeLessThan(30.5);
});

test("without a vertex inside, or with three points, a line has no middle", () => {
  expect(
    middleOf(
      circle(12, 0.4).map(([x, y]): Vec3 => [x + 0.5, y + 0.5, 0]),
      sheet(41),
    ),
  ).toBeNull();
  expect(middleOf(circle(3, 15), sheet(41))).toBeNull();
});

test("the outline of a straight stroke goes along both its sides, half a size away", () => {
  const stroke = Array.from({ length: 5 }, (_, i) => ({ x: 10 * i, y: 50 }));
  expect(outlineOf(stroke, 6)).toEqual([...[0, 10, 20, 30, 40].map((x) => [x, 56]), ...[40, 30, 20, 10, 0].map((x) => [x, 44])]);
});

test("the outline of a stroke in an arc lies on the arcs inside and outside of it", () => {
  const stroke = Array.from({ length: 41 }, (_, i) => ({ x: 100 * Math.cos((Math.PI * i) / 40), y: 100 * Math.sin((Math.PI * i) / 40) }));
  const radii = outlineOf(stroke, 10).map(([x, y]) => Math.hypot(x, y));
  for (const r of radii.slice(2, 39)) expect(r).toBeCloseTo(90, 6);
  for (const r of radii.slice(43, 80)) expect(r).toBeCloseTo(110, 6);
});
