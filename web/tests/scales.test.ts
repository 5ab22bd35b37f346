import { expect, test } from "vitest";

import { DIFFERENCE_COLOURS, DIFFERENCE_LIMITS_MM, widthFor, widthOf } from "../src/geometry/scales";

test("the scale of differences is pale within a quarter of a millimetre, and has as many colours on both sides", () => {
  expect(DIFFERENCE_LIMITS_MM[0]).toBe(0.25);
  expect(DIFFERENCE_COLOURS).toHaveLength(2 * DIFFERENCE_LIMITS_MM.length + 1);
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
