import { Vector3 } from "three";
import { expect, test } from "vitest";

import { PIECES, type Round, glued, sentOf } from "../src/geometry/trimline";

const RADIUS_MM = 50;
const LIFTED = new Vector3(100, 20, -30);

/** A cylinder whose axis is the shown frame's z; the mesh's frame is turned about x, and moved. */
const cylinder: Round = {
  toShown: (p) =>
    p
      .clone()
      .sub(LIFTED)
      .applyAxisAngle(new Vector3(1, 0, 0), -Math.PI / 3),
  toMesh: (p) =>
    p
      .clone()
      .applyAxisAngle(new Vector3(1, 0, 0), Math.PI / 3)
      .add(LIFTED),
  nearest(p) {
    const shown = cylinder.toShown(p);
    const r = Math.hypot(shown.x, shown.y);
    return cylinder.toMesh(new Vector3((shown.x * RADIUS_MM) / r, (shown.y * RADIUS_MM) / r, shown.z));
  },
};

const at = (turn_deg: number, z_mm: number) =>
  cylinder.toMesh(new Vector3(RADIUS_MM * Math.cos((turn_deg * Math.PI) / 180), RADIUS_MM * Math.sin((turn_deg * Math.PI) / 180), z_mm));
const shownOf = (line: readonly Vector3[]) => line.map((p) => cylinder.toShown(p));

test("the line between two points lies on the surface, and turns and rises evenly", () => {
  const line = glued([at(0, 100), at(90, 130)], false, cylinder);
  expect(line).toHaveLength(PIECES + 1);
  shownOf(line).forEach((p, k) => {
    expect(Math.hypot(p.x, p.y)).toBeCloseTo(RADIUS_MM, 6);
    expect((Math.atan2(p.y, p.x) * 180) / Math.PI).toBeCloseTo(9 * k, 6);
    expect(p.z).toBeCloseTo(100 + 3 * k, 6);
  });
});

test("the line goes the short way round, also behind the limb", () => {
  const turns = shownOf(glued([at(170, 0), at(-170, 0)], false, cylinder)).map((p) => Math.atan2(p.y, p.x));
  for (const turn of turns) expect(Math.abs(turn)).toBeGreaterThan((169.9 * Math.PI) / 180);
});

test("a closed line comes back to its first point, and keeps those that were set", () => {
  const set = [at(0, 0), at(120, 0), at(240, 0)];
  const line = glued(set, true, cylinder);
  expect(line).toHaveLength(3 * PIECES);
  set.forEach((p, i) => expect(line[PIECES * i]).toBe(p));
  const length_mm = line.reduce((sum, p, k) => sum + p.distanceTo(line[(k + 1) % line.length]), 0);
  expect(length_mm).toBeCloseTo(3 * PIECES * 2 * RADIUS_MM * Math.sin(Math.PI / (3 * PIECES)), 4);
});

test("one point is no line", () => {
  expect(glued([at(0, 0)], true, cylinder)).toHaveLength(1);
  expect(glued([], false, cylinder)).toEqual([]);
});

test("what is sent are the points that were set, and between far ones others of the line", () => {
  const set = [at(0, 0), at(20, 0), at(120, 0), at(240, 0)];
  const sent = sentOf(set, cylinder);
  // 20 degrees are 17 mm, 100 are 87 mm, 120 are 105 mm: one, four, five and five pieces of at most 25 mm.
  expect(sent).toHaveLength(1 + 4 + 5 + 5);
  for (const p of set) expect(sent).toContain(p);
  sent.forEach((p, k) => expect(p.distanceTo(sent[(k + 1) % sent.length])).toBeLessThan(27));
});
