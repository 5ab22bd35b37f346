import type { Vector3 } from "three";
import { expect, test } from "vitest";

import { changedDifferences } from "../src/geometry/differences";

/** Four vertices of the plane z = 0, each with a difference of its own. */
const positions = Float32Array.of(0, 0, 0, 10, 0, 0, 0, 10, 0, 10, 10, 0);
const differences_mm = Float32Array.of(0.5, 1, 0, -1);
const plane = { signedDistance: (p: Vector3) => ({ signed_mm: p.z, vertex: p.x < 5 ? (p.y < 5 ? 0 : 2) : p.y < 5 ? 1 : 3 }) };

test("what stayed keeps its difference; what moved has the place's, and its way off it", () => {
  const moved = positions.slice();
  moved[5] = -2; // the second vertex carved in by 2 mm
  moved[11] = 1.5; // the fourth one built up
  const values = changedDifferences(moved, { positions, differences_mm, surface: plane });
  expect([...values]).toEqual([0.5, -1, 0, 0.5]);
});

test("a vertex that is new is measured, also where there was none of its number", () => {
  const more = Float32Array.of(...positions, 9, 1, 3);
  expect([...changedDifferences(more, { positions, differences_mm, surface: plane })]).toEqual([0.5, 1, 0, -1, 4]);
});

test("with nothing to measure to, what moved has no difference", () => {
  const moved = positions.slice();
  moved[5] = -2;
  expect([...changedDifferences(moved, { positions, differences_mm, surface: null })]).toEqual([0.5, 0, 0, -1]);
});
