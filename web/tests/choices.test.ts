import { beforeEach, expect, test, vi } from "vitest";

const listening = new Map<string, () => void>();

beforeEach(() => {
  const kept = new Map<string, string>();
  vi.stubGlobal("addEventListener", (what: string, heard: () => void) => listening.set(what, heard));
  vi.stubGlobal("localStorage", { getItem: (k: string) => kept.get(k) ?? null, setItem: (k: string, v: string) => kept.set(k, v) });
  vi.resetModules();
});

test("what the ruler of the print reads goes with the board, and to the next case", async () => {
  const { boardOf, choicesOf, keepChoices } = await import("../src/state/choices");
  expect(boardOf("A")).toMatchObject({ square_mm: 30, ruler: { drawn_mm: 250, measured_mm: 250 } });
  keepChoices("A", { ...choicesOf("A"), ruler_mm: 249.4 });
  expect(boardOf("A")).toMatchObject({ square_mm: 30, ruler: { drawn_mm: 250, measured_mm: 249.4 } });
  expect(boardOf("B")).toMatchObject({ ruler: { measured_mm: 249.4 } });
  keepChoices("B", { ...choicesOf("B"), board: "none" });
  expect(boardOf("B")).toBeNull();
});

test("a case keeps the reading that it was computed with, and hands an old one to no other", async () => {
  const { boardOf, choicesOf, keepChoices, rulerOf } = await import("../src/state/choices");
  keepChoices("A", { ...choicesOf("A"), poisson: true });
  keepChoices("B", { ...choicesOf("B"), ruler_mm: 249.4 });
  expect(boardOf("A")).toMatchObject({ ruler: { measured_mm: 249.4 } });
  keepChoices("A", { ...choicesOf("A"), ruler_mm: rulerOf(choicesOf("A")) });
  keepChoices("B", { ...choicesOf("B"), ruler_mm: 250.8 });
  keepChoices("A", { ...choicesOf("A"), poisson: false });
  expect(boardOf("A")).toMatchObject({ ruler: { measured_mm: 249.4 } });
  expect(boardOf("C")).toMatchObject({ ruler: { measured_mm: 250.8 } });
});

test("a reading that no print can have is sent to be refused, and is kept for no other case", async () => {
  const { boardOf, choicesOf, keepChoices, rulerFar } = await import("../src/state/choices");
  expect([237.4, 262.6, 25, Number.NaN].map(rulerFar)).toEqual([true, true, true, true]);
  expect([237.6, 250, 262.4].map(rulerFar)).toEqual([false, false, false]);
  keepChoices("A", { ...choicesOf("A"), ruler_mm: 25 });
  expect(boardOf("A")).toMatchObject({ ruler: { measured_mm: 25 } });
  expect(boardOf("B")).toMatchObject({ ruler: { measured_mm: 250 } });
});

test("a taped girth is sent once it is whole, and only where there is a size", async () => {
  const { choicesOf, tapeLacks, tapesOf } = await import("../src/state/choices");
  const none = choicesOf("A");
  expect([tapeLacks(none), tapesOf(none)]).toEqual([false, []]);
  const begun = { ...none, tape: { height_mm: 150, girth_mm: null } };
  expect([tapeLacks(begun), tapesOf(begun)]).toEqual([true, []]);
  const whole = { ...none, tape: { height_mm: 0, girth_mm: 354 } };
  expect([tapeLacks(whole), tapesOf(whole)]).toEqual([false, [{ height_mm: 0, girth_mm: 354 }]]);
  expect(tapesOf({ ...whole, board: "none" })).toEqual([]);
});

test("a shape without a size is asked for only where no board is looked for", async () => {
  const { jobOf, keepChoices } = await import("../src/state/choices");
  keepChoices("A", { board: "none", unscaled: true });
  expect(jobOf("A")).toMatchObject({ board: null, unscaled: true });
  keepChoices("A", { board: "printed" });
  expect(jobOf("A")).toMatchObject({ unscaled: false, surface: "ball-pivoting" });
});

test("what another window chose meanwhile stays chosen, and is seen here", async () => {
  const { choicesOf, keepChoices } = await import("../src/state/choices");
  keepChoices("A", { cameras: ["one"] });
  const { effect } = await import("@preact/signals");
  const seen: string[] = [];
  effect(() => void seen.push(`${choicesOf("A").cameras} ${choicesOf("A").board}`));
  localStorage.setItem("limbgram.choices.A", JSON.stringify({ ...choicesOf("A"), board: "none" }));
  listening.get("storage")?.();
  keepChoices("A", { cameras: ["two"] });
  expect(seen).toEqual(["one printed", "one none", "two none"]);
});
