import { signal } from "@preact/signals";
import { beforeEach, expect, test, vi } from "vitest";

import { json, stubBrowser } from "./browser";
import { running } from "./hook";

beforeEach(() => {
  stubBrowser();
  vi.stubGlobal("fetch", async () => json({ aligned: true, places: [] }));
  vi.resetModules();
});

/** An aligned case with this limb. */
function subjectOf(limb: { frame: object; reply: object } | null) {
  const nothing = async () => {};
  return {
    openCase: { id: "K7Q-4F2", again: nothing },
    limb,
    aligned: true,
    kind: "transtibial",
    side: "left",
    saved: signal(""),
    act: { run: async (act: () => Promise<void>) => await act() },
    asked: { again: nothing, askedSince: () => false },
    take: () => {},
  };
}

test("axes that were set by the way somebody looked are set: the next thing is to measure", async () => {
  const { useAxes } = await import("../src/screens/align/axes");
  const subject = subjectOf(null);
  const made = await running(() => useAxes(subject as never, { places: [], known: [] } as never));
  expect(made.now.chosenAnew).toBe(false);
  made.now.front.value = [0, 1, 0];
  await made.rest();
  expect(made.now.chosenAnew).toBe(true);
  made.now.set();
  await made.rest();
  expect(made.now.chosenAnew).toBe(false);
  made.now.front.value = null;
  await made.rest();
  expect(made.now.chosenAnew).toBe(true);
});

test("axes that are set again keep the end up that is shown, as their form says", async () => {
  const sent: { proximal: number[] }[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    sent.push((await request.json()) as { proximal: number[] });
    return json({ aligned: true, places: [] });
  });
  const { useAxes } = await import("../src/screens/align/axes");
  const rotation = [
    [1, 0, 0],
    [0, -1, 0],
    [0, 0, -1],
  ];
  const subject = subjectOf({
    frame: { rotation, translation: [0, 0, 0] },
    reply: { flexion_deg: 0 },
  });
  const made = await running(() => useAxes(subject as never, { places: [], known: [] } as never));
  made.now.set();
  await made.rest();
  made.now.flipped.value = true;
  made.now.set();
  await made.rest();
  made.now.flexion_deg.value = 90;
  made.now.set();
  await made.rest();
  expect(sent.map((one) => one.proximal.map((value) => Math.round(value) + 0))).toEqual([
    [0, 0, -1],
    [0, 0, 1],
    [0, 1, 0],
  ]);
});

test("axes that are set again on a page loaded anew keep the flexion of the joint", async () => {
  const sent: { proximal: number[]; flexion_deg: number }[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    sent.push((await request.json()) as { proximal: number[]; flexion_deg: number });
    return json({ aligned: true, places: [] });
  });
  const { useAxes } = await import("../src/screens/align/axes");
  const turn = Math.PI / 3;
  const rotation = [
    [1, 0, 0],
    [0, Math.cos(turn), -Math.sin(turn)],
    [0, Math.sin(turn), Math.cos(turn)],
  ];
  const loaded = { frame: { rotation, translation: [0, 0, 0] }, reply: { flexion_deg: 60 } };
  const subject = subjectOf(null);
  const arrived = signal(false);
  const made = await running(() => {
    const limb = arrived.value ? loaded : null;
    return useAxes({ ...subject, limb } as never, { places: [], known: [] } as never);
  });
  arrived.value = true;
  await made.rest();
  made.now.set();
  await made.rest();
  expect(sent[0].flexion_deg).toBe(60);
  expect(sent[0].proximal.map((value) => Math.round(1000 * value) + 0)).toEqual([0, 0, 1000]);
});
