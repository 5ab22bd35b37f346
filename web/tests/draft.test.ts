import { expect, test } from "vitest";

import { begun, bodyOf, pulled, wayOf } from "../src/screens/rectify/draft";

const AT = { anchor: [1, 2, 3], normal: [0, 0, 1], seed: 7, falloff_mm: 14 } as const;

test("an edit begins as a load of two millimetres", () => {
  expect(begun(AT)).toMatchObject({ kind: "load", depth_mm: 2, flat_mm: 0, at: null, within: [] });
});

test("the server is told a landmark by its name, a place by its position, a region by its line", () => {
  expect(bodyOf(begun({ ...AT, at: "fibula head" }))).toEqual({
    kind: "load",
    parameters: { depth_mm: 2, falloff_mm: 14, at: "fibula head", flat_mm: 0 },
    accept: [],
  });
  expect(bodyOf(begun({ ...AT, at: [4, 5, 6], flat_mm: 3 })).parameters).toEqual({
    depth_mm: 2,
    falloff_mm: 14,
    at: [4, 5, 6],
    flat_mm: 3,
    positions_in: "mesh",
  });
  expect(bodyOf(begun(AT)).parameters).toMatchObject({ at: [1, 2, 3] });
  const within = [
    [0, 0, 0],
    [9, 0, 0],
    [9, 9, 0],
    [0, 9, 0],
  ] as const;
  expect(bodyOf(begun({ ...AT, within })).parameters).toEqual({ depth_mm: 2, falloff_mm: 14, within: within.map((p) => [...p]), positions_in: "mesh" });
});

test("the handle carves in when it is pushed, builds up when it is pulled, in steps unless the hand is fine", () => {
  const load = begun(AT);
  expect(pulled(load, -3.3, false)).toMatchObject({ kind: "load", depth_mm: 3.5 });
  expect(pulled(load, 1.2, false)).toMatchObject({ kind: "relieve", depth_mm: 1 });
  expect(pulled(load, 1.234, true)).toMatchObject({ kind: "relieve", depth_mm: 1.23 });
  expect(pulled(load, 0.2, false).depth_mm).toBe(0);
  expect(wayOf(pulled(load, -3, false))).toBe(-1);
  expect(wayOf(pulled(load, 3, false))).toBe(1);
});
