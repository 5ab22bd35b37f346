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
  const kept = "95 % of the measured surface is expected within 0.09 mm of the limb (limit 0.60 mm).";
  expect(inShort(`GREEN: 0.09 mm. ${kept}`)).toBe("Within 0.09\u00a0mm");
  expect(inShort(`GREEN for the shape; size unchecked: it rests on one board alone, and no length off it was given. 0.09 mm. ${kept}`)).toBe("Within 0.09\u00a0mm; size unchecked");
  expect(inShort("AMBER: 10.1 % of the surface was filled in; no photo measured it. What was measured is sure to 0.20 mm.")).toBe("10.1 % of the surface was filled in");
});

test("what an edit asks for is offered as words where it may be only some", async () => {
  const { choicesOf, valueOf } = await import("../src/screens/other-edit");
  expect(choicesOf({ expected: "Literal['girth', 'volume']" })).toEqual(["girth", "volume"]);
  expect(choicesOf({ expected: "bool, else True" })).toEqual(["True", "False"]);
  expect(choicesOf({ expected: "float, else 0.3" })).toEqual([]);
  expect(valueOf("True", { expected: "bool, else True" })).toBe(true);
  expect(valueOf("0,5", { expected: "float" })).toBe(0.5);
});
