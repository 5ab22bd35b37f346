import { signal } from "@preact/signals";
import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";
import { running } from "./hook";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

/** The open edit of a limb that is not here yet: what a hand does to its depth. */
async function opened() {
  const { useOpenEdit } = await import("../src/screens/rectify/open-edit");
  const { begun } = await import("../src/screens/rectify/draft");
  const cleared: string[] = [];
  const trial = { tried: signal(null), waits: signal(false), refused: signal(null), ask: async () => {}, passOver: () => {} };
  const around = {
    viewer: { current: { surface: null, draw: () => {} } },
    level: signal(null),
    base: { limb: null, data: null, differences_mm: new Float32Array() },
    trial,
    drawing: { line: signal([]), clear: () => void cleared.push("drawing") },
    trimline: { clear: () => void cleared.push("trimline") },
    keeping: { now: signal(false), offer: { over: () => {} } },
  };
  const made = await running(() => useOpenEdit(around as never));
  const open = () => made.now.open(begun({ anchor: [0, 0, 0], normal: [0, 0, 1], seed: 0, falloff_mm: 14 }));
  open();
  /** Drag the handle as a pointer does: many moves, and where it was last once more as it lets go. */
  const drag = (...outward_mm: number[]) => {
    for (const mm of outward_mm) made.now.pull(mm, false, false);
    made.now.pull(outward_mm[outward_mm.length - 1], true, false);
  };
  return { made, open, drag, cleared };
}

test("an edit that is dragged deeper than 8 mm is asked for once more", async () => {
  const { made, drag } = await opened();
  drag(-3, -6, -9, -12);
  expect(made.now.asksDepth.value).toBe(true);
  made.now.asksDepth.value = false;
  drag(-12.5, -13);
  expect(made.now.asksDepth.value).toBe(false); // it was said to be meant
});

test("nothing is asked of an edit that became shallow again, nor of the next one", async () => {
  const { made, open, drag } = await opened();
  drag(-9, -12);
  drag(-7, -5);
  expect(made.now.asksDepth.value).toBe(false);
  drag(-9, -12);
  made.now.change({ depth_mm: 4 });
  expect(made.now.asksDepth.value).toBe(false);
  made.now.pull(-12, true, false);
  expect(made.now.asksDepth.value).toBe(true);
  made.now.drop();
  open();
  expect(made.now.asksDepth.value).toBe(false);
});

test("what is dropped leaves nothing that was drawn, corners of a region neither", async () => {
  const { made, cleared } = await opened();
  cleared.length = 0;
  made.now.drop();
  expect(cleared).toEqual(["drawing", "trimline"]);
});
