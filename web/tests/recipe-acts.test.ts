import { beforeEach, expect, test, vi } from "vitest";

beforeEach(() => {
  vi.stubGlobal("location", { origin: "http://127.0.0.1:8000", hash: "" });
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => {} });
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
});

const edits = ["sock", "load", "smoothing"].map((kind, i) => ({
  number: i + 1,
  kind,
  on: true,
  accept: [],
  parameters: { depth_mm: i },
  telling: ["depth_mm"],
  text: kind,
}));

async function after(...acts: readonly (readonly [string, number, object?])[]) {
  const { EDIT, afterActs } = await import("../src/screens/recipe-acts");
  return afterActs(
    { edits, act: null },
    acts.map(([method, number, body], i) => ({ id: `act ${i}`, method, path: EDIT, init: { params: { path: { number } }, body } })),
  );
}

test("numbers are those after the changes that are on their way", async () => {
  expect((await after(["delete", 1], ["delete", 1]))?.map((one) => [one.number, one.kind])).toEqual([[1, "smoothing"]]);
  expect((await after(["patch", 3, { number: 1 }]))?.map((one) => [one.number, one.kind, one.was])).toEqual([
    [1, "smoothing", 3],
    [2, "sock", 1],
    [3, "load", 2],
  ]);
});

test("what a recipe has in it already is not done to it again, though its answer is late", async () => {
  const { EDIT, afterActs } = await import("../src/screens/recipe-acts");
  const acts = ["first", "second"].map((id) => ({ id, method: "delete", path: EDIT, init: { params: { path: { number: 1 } } } }));
  const names = (list: readonly { readonly kind: string }[] | null) => list?.map((one) => one.kind);
  expect(names(afterActs({ edits, act: "an act of before" }, acts))).toEqual(["smoothing"]);
  expect(names(afterActs({ edits: edits.slice(1), act: "first" }, acts))).toEqual(["smoothing"]);
  expect(names(afterActs({ edits: edits.slice(2), act: "second" }, acts))).toEqual(["smoothing"]);
});

test("a switch that is pressed twice is as it was, and a changed edit has no figures yet", async () => {
  expect((await after(["patch", 2, { on: false }]))?.[1].on).toBe(false);
  expect((await after(["patch", 2, { on: false }], ["patch", 2, { on: true }]))?.[1].on).toBe(true);
  expect((await after(["patch", 2, { parameters: { depth_mm: 3 } }]))?.[1]).toMatchObject({ parameters: { depth_mm: 3 }, was: null });
});

test("what undo brings is not guessed, and what is added comes with its answer", async () => {
  const { EDITS, RECIPE, afterActs } = await import("../src/screens/recipe-acts");
  expect(afterActs({ edits, act: null }, [{ id: "undo", method: "post", path: `${RECIPE}/undo`, init: {} }])).toBeNull();
  expect(afterActs({ edits, act: null }, [{ id: "add", method: "post", path: EDITS, init: {} }])?.map((one) => one.kind)).toEqual([
    "sock",
    "load",
    "smoothing",
  ]);
});

test("a change is made on what the one before it makes", async () => {
  const { seenBy } = await import("../src/screens/recipe-acts");
  const act = { id: "a1", by: "", lane: "K7Q-4F2", method: "patch", path: "", init: {} };
  expect(seenBy([], "mark")).toBe("mark");
  expect(seenBy([act, { ...act, id: "a2" }], "mark")).toBe("a2");
});

test("the edit that is looked at keeps being looked at, whichever edit is moved", async () => {
  const { movedTo } = await import("../src/screens/recipe-acts");
  const list = ["a", "b", "c", "d", "e"];
  for (let from = 1; from <= 5; from++)
    for (let to = 1; to <= 5; to++) {
      const after = list.filter((_, i) => i !== from - 1).toSpliced(to - 1, 0, list[from - 1]);
      list.forEach((one, i) => expect(after[movedTo(i + 1, from, to) - 1]).toBe(one));
    }
});
