import { beforeEach, expect, test, vi } from "vitest";

import type { Parameter } from "../src/edits";
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
  const { inShort, sizeUnchecked } = await import("../src/screens/cases");
  const { words } = await import("../src/words");
  const filled = "{filled_percent:.1f} % of the surface was filled in; no photo measured it.";
  words.value = {
    en: {
      codes: {
        "verdict.green": { says: "Surface: {scale}", short: "Within {p95_mm:.2f} mm" },
        "verdict.doubtful": { says: "{first} {scale}", short: "{first:short}" },
        "verdict.filled": { says: filled, short: "{filled_percent:.1f} % was filled in" },
        "verdict.open": { says: "It is open at 1.5 mm: close it." },
        "verdict.no_size": { says: "No millimetres. {size}", short: "No millimetres" },
        "verdict.scale.unknown": { says: "Nothing says how large it is." },
      },
      terms: {},
    },
  };
  const headline = (gravity: string, code: string, values: Record<string, Value>) => ({
    code: "verdict.headline",
    gravity,
    values: { verdict: { code, gravity, values } },
  });
  const green = headline("note", "verdict.green", { p95_mm: 0.09, limit_mm: 0.6 });
  expect(inShort(green)).toBe("Within 0.09 mm");
  expect(sizeUnchecked({ size_checked: false, headline: green })).toBe(true);
  expect(sizeUnchecked({ size_checked: true, headline: green })).toBe(false);
  const amber = headline("doubt", "verdict.doubtful", {
    first: { code: "verdict.filled", gravity: "doubt", values: { filled_percent: 10.1 } },
    second: null,
    p95_mm: 0.2,
  });
  expect(inShort(amber)).toBe("10.1 % was filled in");
  const open = headline("doubt", "verdict.doubtful", { first: { code: "verdict.open", gravity: "doubt", values: {} }, second: null });
  expect(inShort(open)).toBe("It is open at 1.5 mm: close it.");
  const red = headline("fault", "verdict.no_size", { size: { code: "verdict.scale.unknown", gravity: "fault", values: {} } });
  expect(inShort(red)).toBe("No millimetres");
  expect(sizeUnchecked({ size_checked: false, headline: red })).toBe(false);
});

test("what an edit asks for is offered as words where it may be only some, and its range is told", async () => {
  const { choicesOf, rangeOf, valueOf } = await import("../src/screens/other-edit");
  const field = (own: Partial<Parameter>): Parameter => ({
    name: "",
    expected: "a number",
    meaning: "",
    unit: "",
    needed: false,
    above: false,
    choices: [],
    several: false,
    ...own,
  });
  expect(choicesOf(field({ expected: "one of girth, volume", choices: ["girth", "volume"] }))).toEqual(["girth", "volume"]);
  expect(choicesOf(field({ expected: "true or false" }))).toEqual(["true", "false"]);
  expect(choicesOf(field({ expected: "a number" }))).toEqual([]);
  expect(valueOf("true", field({ expected: "true or false" }))).toBe(true);
  expect(valueOf("0,5", field({ expected: "a number" }))).toBe(0.5);
  expect(valueOf("1 2,5", field({ expected: "a list in brackets", several: true }))).toEqual([1, 2, 5]);
  expect(valueOf("80,5; 200", field({ expected: "a list in brackets", several: true }))).toEqual([80.5, 200]);
  expect(rangeOf(field({ least: 0, most: 20, above: true, unit: "mm" }))).toBe("Above 0, up to 20\u00a0mm.");
  expect(rangeOf(field({ least: 1, most: 500 }))).toBe("From 1 to 500.");
  expect(rangeOf(field({ least: 0, most: 2000, unit: "mm" }))).toBe("");
});

test("an edit that nobody here knows is called as the server says, in the language chosen", async () => {
  const { summaryOf } = await import("../src/screens/edit-words");
  const { editKinds } = await import("../src/edits");
  const { setLanguage } = await import("../src/texts");
  const one = { number: 1, kind: "twist", on: true, accept: [], parameters: { by_deg: 3, about: "ankle" }, telling: ["by_deg", "about"], text: "" };
  expect(summaryOf(one)).toMatchObject({ title: "twist", where: "by_deg 3; about ankle" });
  const words = (name: string, by: string, ankle: string) => ({ name, group: "", does: "", labels: { by_deg: by, about: "" }, help: {}, choices: { ankle } });
  editKinds.value = [
    {
      kind: "twist",
      group: "ends",
      everyday: true,
      does: "",
      parameters: [],
      rarely: [],
      kinds: [],
      words: { en: words("Twist", "By", "the ankle"), de: words("Verdrehen", "Um", "das Sprunggelenk") },
    },
  ];
  expect(summaryOf(one)).toMatchObject({ title: "Twist", where: "By 3;  the ankle" });
  setLanguage("de");
  expect(summaryOf(one)).toMatchObject({ title: "Verdrehen", where: "Um 3;  das Sprunggelenk" });
  setLanguage("en");
  editKinds.value = [];
});

test("two files of one limb are told apart by what they are made of", async () => {
  const { madeOf } = await import("../src/screens/send");
  const one = { side: "left", recipe_edits: 3, signed_by: "", scan_sha256: "0123456789abcdef", recipe_sha256: "fedcba9876543210" } as const;
  expect(madeOf(one)).toBe("LEFT · 3 edits · scan 01234567 · recipe fedcba98");
  expect(madeOf({ ...one, side: "none", recipe_edits: 1, signed_by: "A. Meier", recipe_sha256: "" })).toBe("1 edit · signed by A. Meier · scan 01234567");
});
