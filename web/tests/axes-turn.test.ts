import { expect, test } from "vitest";

import { STILL, turned } from "../src/geometry/axes-turn";
import { IDENTITY, type Vec3, apply, cross, dot } from "../src/geometry/vectors";

const near = (a: Vec3, b: Vec3) => a.forEach((v, i) => expect(v).toBeCloseTo(b[i], 9));

test("nothing done leaves the frame", () => {
  const frame = { ...IDENTITY, translation: [1, 2, 3] as Vec3 };
  expect(turned(frame, STILL)).toEqual(frame);
});

test("each handle goes the way that its words say", () => {
  const [front, proximal]: Vec3[] = [
    [0, 1, 0],
    [0, 0, 1],
  ];
  near(apply(turned(IDENTITY, { ...STILL, turn_deg: 90 }), front), [-1, 0, 0]);
  near(apply(turned(IDENTITY, { ...STILL, flex_deg: 90 }), proximal), [0, -1, 0]);
  near(apply(turned(IDENTITY, { ...STILL, lean_deg: 90 }), proximal), [1, 0, 0]);
});

test("what the hand did is a rotation, whatever it did", () => {
  const { rotation } = turned(IDENTITY, { turn_deg: 31, flex_deg: -12, lean_deg: 7 });
  for (const row of rotation) expect(dot(row, row)).toBeCloseTo(1, 12);
  near(cross(rotation[0], rotation[1]), rotation[2]);
});

test("turned about the long axis, heights stay", () => {
  const by = turned(IDENTITY, { ...STILL, turn_deg: 17 });
  expect(apply(by, [30, -12, 88])[2]).toBeCloseTo(88, 12);
});
