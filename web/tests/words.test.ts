import { beforeEach, expect, test, vi } from "vitest";

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
  const surface = "Surface: 95 % within 0.09 mm (limit 0.60 mm).";
  const set = "Scale: set by one board, 4 check lengths agree to 0.004 %";
  expect(inShort({ light: "green", size_checked: false, headline: `GREEN. ${surface} ${set}; not checked independently.` })).toBe("Within 0.09\u00a0mm; size not checked");
  expect(inShort({ light: "green", size_checked: true, headline: `GREEN. ${surface} ${set}; confirmed to 0.6 % by tape.` })).toBe("Within 0.09\u00a0mm");
  const filled = "10.1 % of the surface was filled in; no photo measured it.";
  expect(inShort({ light: "amber", size_checked: true, headline: `AMBER. ${filled} Measured surface: 95 % within 0.20 mm. ${set}; checked independently.` })).toBe("10.1 % of the surface was filled in");
  expect(inShort({ light: "amber", size_checked: false, headline: `AMBER. ${filled} Measured surface: 95 % within 0.20 mm. ${set}; not checked independently.` })).toBe("10.1 % of the surface was filled in; size not checked");
  expect(inShort({ light: "red", size_checked: false, headline: "RED. No millimetres. Nothing in the photos says how large the limb is." })).toBe("No millimetres");
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
