import { expect, test } from "vitest";

import { type Place, nextAfter, offeredOf, orderOf, withPending } from "../src/screens/align/places";

const at = (name: string, x_mm: number): Place => ({ name, position_mm: [x_mm, 0, 0] });
const KNOWN = ["a", "b", "c", "d"].map((name) => ({ name, facing: "none" }) as const);
const NONE = new Set<string>();

const put = (name: string, x_mm: number) => ({ method: "put", init: { params: { path: { name } }, body: { position_mm: [x_mm, 0, 0] } } });
const taken = (name: string) => ({ method: "delete", init: { params: { path: { name } } } });

test("places that are on their way stand where they were put last, and go when they are taken away", () => {
  const kept = [at("a", 1), at("b", 2)];
  const places = withPending(kept, [put("c", 3), put("a", 7), taken("b"), put("c", 4)]);
  expect(places.map((one) => [one.name, one.position_mm[0]])).toEqual([
    ["a", 7],
    ["c", 4],
  ]);
  expect(withPending(kept, [])).toBe(kept);
});

test("the list has the names of the kind first, then those that were set besides", () => {
  expect(orderOf(KNOWN, [at("mine", 0), at("b", 1)])).toEqual(["a", "b", "c", "d", "mine"]);
});

test("after a place comes the next that is neither set nor left out, round to the first", () => {
  const order = orderOf(KNOWN, []);
  expect(nextAfter("a", order, [at("b", 0)], NONE)).toBe("c");
  expect(nextAfter("a", order, [at("b", 0)], new Set(["c"]))).toBe("d");
  expect(nextAfter("d", order, [at("b", 0)], NONE)).toBe("a");
  expect(nextAfter("a", order, [at("b", 0), at("c", 0)], new Set(["d"]))).toBeNull();
});

test("a guess is offered until its name is set, or something nearer than 3 mm", () => {
  const guesses = [
    { by: "shape", name: "a", position_mm: [0, 0, 0] },
    { by: "shape", name: "b", position_mm: [100, 0, 0] },
    { by: "sticker", name: "", sticker: 4, position_mm: [50, 0, 0] },
    { by: "sticker", name: "", sticker: 5, position_mm: [70, 0, 0] },
  ] as const;
  const found = offeredOf(
    guesses.map((one) => ({ ...one, position_mm: [...one.position_mm] })),
    [at("a", 300), at("c", 72)],
    (sticker) => (sticker === 4 ? "d" : ""),
  );
  expect(found).toEqual([
    { name: "b", sticker: null, by: "shape", at: [100, 0, 0], sigma_mm: null, within_mm: null },
    { name: "d", sticker: 4, by: "sticker", at: [50, 0, 0], sigma_mm: null, within_mm: null },
  ]);
  expect(offeredOf([{ by: "shape", name: "b", position_mm: [100, 0, 0] }], [at("c", 103.1)], () => "")).toHaveLength(1);
});
