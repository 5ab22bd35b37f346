import { expect, test } from "vitest";

import { type Pixel, nearestPixel, nearestVertex } from "../src/geometry/nearest";

const CORNERS = Float32Array.of(0, 0, 0, 10, 0, 0, 10, 10, 0, 0, 10, 5);

test("the nearest vertex is the nearest in all three directions, the first of equals", () => {
  expect(nearestVertex(CORNERS, [9, 1, 0])).toBe(1);
  expect(nearestVertex(CORNERS, [0, 10, 4])).toBe(3);
  expect(nearestVertex(CORNERS, [5, 0, 0])).toBe(0);
});

test("on the page only what is seen and nearer than the reach is found", () => {
  const places: (Pixel | null)[] = [[100, 100], null, [112, 100], [106, 100]];
  expect(nearestPixel(places, [105, 100], 14)).toBe(3);
  expect(nearestPixel(places, [113, 100], 14)).toBe(2);
  expect(nearestPixel(places, [130, 100], 14)).toBeNull();
  expect(nearestPixel(places, [126, 100], 14)).toBeNull(); // at the reach itself nothing is found
  expect(nearestPixel([], [0, 0], 14)).toBeNull();
});
