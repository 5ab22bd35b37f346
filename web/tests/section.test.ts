import { expect, test } from "vitest";

import { cut, heightsOf, hull } from "../src/geometry/section";
import type { Vec3 } from "../src/geometry/vectors";

/** A tube of radius r(angle), open at both ends, z from 0 to 100. */
function tube(radius: (angle: number) => number, around = 720, along = 11): [Float32Array, Uint32Array] {
  const positions: number[] = [];
  const indices: number[] = [];
  for (let j = 0; j < along; j++)
    for (let i = 0; i < around; i++) {
      const a = (2 * Math.PI * i) / around;
      positions.push(radius(a) * Math.cos(a), radius(a) * Math.sin(a), (100 * j) / (along - 1));
    }
  for (let j = 0; j + 1 < along; j++)
    for (let i = 0; i < around; i++) {
      const k = (i + 1) % around;
      const [a, b, c, d] = [j * around + i, j * around + k, (j + 1) * around + i, (j + 1) * around + k];
      indices.push(a, b, d, a, d, c);
    }
  return [Float32Array.from(positions), Uint32Array.from(indices)];
}

test("a round tube has the girth and the area of its circle", () => {
  const [positions, indices] = tube(() => 50);
  const section = cut(positions, indices, heightsOf(positions), 33.3);
  expect(section.loops).toHaveLength(1);
  expect(section.tape_mm).toBeCloseTo(2 * Math.PI * 50, 1);
  expect(section.area_mm2).toBeCloseTo(Math.PI * 2500, -1);
  for (const p of section.loops[0]) expect(p[2]).toBeCloseTo(33.3, 4);
});

test("a taut tape bridges a hollow that the contour follows", () => {
  const [positions, indices] = tube((a) => 50 - 12 * Math.exp(-((a - Math.PI) ** 2) / 0.05));
  const section = cut(positions, indices, heightsOf(positions), 50);
  expect(section.tape_mm).toBeLessThan(2 * Math.PI * 50);
  expect(section.contour_mm).toBeGreaterThan(section.tape_mm + 2);
});

test("a level through a row of vertices still closes", () => {
  const [positions, indices] = tube(() => 40, 90);
  const section = cut(positions, indices, heightsOf(positions), 50);
  expect(section.tape_mm).toBeGreaterThan(2 * 90 * 40 * Math.sin(Math.PI / 90) * 0.999);
});

test("of two limbs the one on the axis is measured", () => {
  const [positions, indices] = tube(() => 50);
  const [other] = tube(() => 60);
  const aside = other.map((value, i) => (i % 3 === 0 ? value + 200 : value));
  const n = positions.length / 3;
  const both = Float32Array.from([...positions, ...aside]);
  const section = cut(both, Uint32Array.from([...indices, ...indices.map((i) => i + n)]), heightsOf(both), 33.3);
  expect(section.loops).toHaveLength(2);
  expect(section.tape_mm).toBeCloseTo(2 * Math.PI * 50, 1);
});

/** Tubes round one another or beside one another, as one surface. */
function together(...tubes: (readonly [radius: number, aside_mm: number])[]): [Float32Array, Uint32Array, Float32Array] {
  const parts = tubes.map(([radius, aside_mm]) => {
    const [positions, indices] = tube(() => radius);
    return [positions.map((value, i) => (i % 3 === 0 ? value + aside_mm : value)), indices] as const;
  });
  const positions = Float32Array.from(parts.flatMap(([own]) => [...own]));
  const n = parts[0][0].length / 3;
  return [positions, Uint32Array.from(parts.flatMap(([, own], k) => [...own].map((i) => i + k * n))), heightsOf(positions)];
}

test("of a wall the inside is measured where the limb lies in it", () => {
  const wall = together([54, 0], [50, 0]);
  expect(cut(...wall, 33.3).tape_mm).toBeCloseTo(2 * Math.PI * 54, 1);
  const inside = cut(...wall, 33.3, undefined, "hollow");
  expect(inside.tape_mm).toBeCloseTo(2 * Math.PI * 50, 1);
  expect(inside.area_mm2).toBeCloseTo(Math.PI * 2500, -1);
});

test("a hole for a screw is no inside, nor is a limb beside the wall", () => {
  expect(cut(...together([54, 0], [4, 40]), 33.3, undefined, "hollow").tape_mm).toBeNaN();
  expect(cut(...together([54, 0], [50, 200]), 33.3, undefined, "hollow").tape_mm).toBeNaN();
  expect(cut(...together([54, 0], [4, 48], [44, 0], [50, 200]), 33.3, undefined, "hollow").tape_mm).toBeCloseTo(2 * Math.PI * 44, 1);
});

test("a contour and a tape are smoothed over 5 mm", () => {
  const plain = 2 * Math.PI * 50;
  const knitted = (wave: number): [Float32Array, Uint32Array, Float32Array] => {
    const [positions, indices] = tube((a) => 50 + 0.05 * Math.cos(Math.round(plain / wave) * a), 3000, 3);
    return [positions, indices, heightsOf(positions)];
  };
  const knit = (wave: number) => cut(...knitted(wave), 50);
  // A quarter of the squared slope, of which 0.0006 stays at 2 mm and 0.89 at 10 mm.
  expect(Math.abs(knit(2).contour_mm - plain)).toBeLessThan(0.01);
  expect(knit(10).contour_mm - plain).toBeCloseTo((plain * (0.05 * 0.2 * Math.PI) ** 2 * 0.885) / 4, 2);
  // On the tops of the knit a tape would read 0.05 * 2 pi more; 0.025 of its height stays at 2 mm.
  expect(Math.abs(knit(2).tape_mm - plain)).toBeLessThan(0.01);
});

test("beyond the limb there is nothing", () => {
  const [positions, indices] = tube(() => 40, 90);
  const section = cut(positions, indices, heightsOf(positions), 150);
  expect(section.loops).toHaveLength(0);
  expect(section.tape_mm).toBeNaN();
});

test("an open half tube gives a line and no girth", () => {
  const [positions, indices] = tube(() => 40, 90);
  const half = indices.filter((_, i) => {
    const f = i - (i % 3);
    return [0, 1, 2].every((k) => positions[3 * indices[f + k] + 1] >= 0);
  });
  const section = cut(positions, half, heightsOf(positions), 47);
  expect(section.loops).toHaveLength(1);
  expect(section.tape_mm).toBeNaN();
});

test("the hull of a square with points inside is the square", () => {
  const points: Vec3[] = [
    [0, 0, 0],
    [4, 0, 0],
    [4, 4, 0],
    [0, 4, 0],
    [2, 2, 0],
    [1, 3, 0],
  ];
  expect(hull(points)).toHaveLength(4);
});
