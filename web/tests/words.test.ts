import { beforeEach, expect, test, vi } from "vitest";

import type { Value } from "../src/words";

beforeEach(() => {
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => {} });
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: () => {} }));
  vi.stubGlobal("location", { hash: "" });
  vi.stubGlobal("addEventListener", () => {});
});

test("a row of the list says what the surface keeps to, and the first doubt", async () => {
  const { inShort } = await import("../src/screens/cases");
  const { words } = await import("../src/words");
  const filled = "{filled_percent:.1f} % of the surface was filled in; no photo measured it.";
  words.value = { en: { codes: { "verdict.filled": { says: filled }, "verdict.no_size": { says: "No millimetres. {size}" }, "verdict.scale.unknown": { says: "Nothing says how large it is." } }, terms: {} } };
  const headline = (gravity: string, code: string, values: Record<string, Value>) => ({ code: "verdict.headline", gravity, values: { verdict: { code, gravity, values } } });
  const green = headline("note", "verdict.green", { p95_mm: 0.09, limit_mm: 0.6 });
  expect(inShort({ size_checked: false, headline: green })).toBe("Within 0.09\u00a0mm; size not checked");
  expect(inShort({ size_checked: true, headline: green })).toBe("Within 0.09\u00a0mm");
  const amber = headline("doubt", "verdict.doubtful", { first: { code: "verdict.filled", gravity: "doubt", values: { filled_percent: 10.1 } }, second: null, p95_mm: 0.2 });
  expect(inShort({ size_checked: true, headline: amber })).toBe("10.1 % of the surface was filled in");
  expect(inShort({ size_checked: false, headline: amber })).toBe("10.1 % of the surface was filled in; size not checked");
  const red = headline("fault", "verdict.no_size", { size: { code: "verdict.scale.unknown", gravity: "fault", values: {} } });
  expect(inShort({ size_checked: false, headline: red })).toBe("No millimetres");
});

test("what an edit asks for is offered as words where it may be only some", async () => {
  const { choicesOf, valueOf } = await import("../src/screens/other-edit");
  expect(choicesOf({ expected: "Literal['girth', 'volume']" })).toEqual(["girth", "volume"]);
  expect(choicesOf({ expected: "bool, else True" })).toEqual(["True", "False"]);
  expect(choicesOf({ expected: "float, else 0.3" })).toEqual([]);
  expect(valueOf("True", { expected: "bool, else True" })).toBe(true);
  expect(valueOf("0,5", { expected: "float" })).toBe(0.5);
});

test("two files of one limb are told apart by what they are made of", async () => {
  const { madeOf } = await import("../src/screens/send");
  const one = { side: "left", recipe_edits: 3, signed_by: "", scan_sha256: "0123456789abcdef", recipe_sha256: "fedcba9876543210" } as const;
  expect(madeOf(one)).toBe("LEFT · 3 edits · scan 01234567 · recipe fedcba98");
  expect(madeOf({ ...one, side: "none", recipe_edits: 1, signed_by: "A. Meier", recipe_sha256: "" })).toBe("1 edit · signed by A. Meier · scan 01234567");
});
