import { expect, test } from "vitest";

import { touching } from "../src/screens/rectify/skin";

const offset = { kind: "offset", parameters: { distance_mm: 2 } };
const wall = (side?: string) => ({ kind: "wall", parameters: { thickness_mm: 4, ...(side && { side }) } });

test("a limb, and a wall that was made inwards, touch by their outside", () => {
  expect(touching([])).toBe("outline");
  expect(touching([offset])).toBe("outline");
  expect(touching([offset, wall("inward")])).toBe("outline");
});

test("a wall that was made outwards touches by its inside, and so does what is done to it", () => {
  expect(touching([offset, wall("outward")])).toBe("hollow");
  expect(touching([wall(), offset])).toBe("hollow");
});

test("a wall that is switched off touches nothing", () => {
  expect(touching([{ ...wall(), on: false }])).toBe("outline");
});
