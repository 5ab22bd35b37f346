import { expect, test } from "vitest";

import { bandOf, widthFor, widthOf } from "../src/geometry/scales";

test("the scale of differences is symmetric, and pale within a quarter of a millimetre", () => {
  expect(bandOf(0.25)).toBe(4);
  expect(bandOf(-0.25)).toBe(4);
  for (const mm of [0.3, 0.7, 1.5, 3]) expect(bandOf(mm) + bandOf(-mm)).toBe(8);
  expect(bandOf(9)).toBe(8);
  expect(bandOf(0.45)).toBe(6); // beyond the 0.40 mm that the report draws, too
  expect(bandOf(3, 2)).toBe(7);
});

test("beyond 4 mm the range doubles", () => {
  expect(widthFor(4)).toBe(1);
  expect(widthFor(4.1)).toBe(2);
  expect(widthFor(9)).toBe(4);
});

test("the width is that of the largest difference on either side", () => {
  expect(widthOf(Float32Array.of(0.1, -4, 3))).toBe(1);
  expect(widthOf(Float32Array.of(0.1, -9, 3))).toBe(4);
  expect(widthOf(new Float32Array())).toBe(1);
});
