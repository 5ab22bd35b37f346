import { beforeEach, expect, test, vi } from "vitest";

beforeEach(() => {
  const kept = new Map<string, string>();
  vi.stubGlobal("localStorage", { getItem: (k: string) => kept.get(k) ?? null, setItem: (k: string, v: string) => kept.set(k, v) });
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: () => {} }));
  vi.resetModules();
});

const PUT = {
  code: "recipe.load_on",
  gravity: "doubt",
  values: { place: "tibial crest", why: "bone edge under the skin" },
  sentence: "the load is put on the tibial crest: bone edge under the skin",
};
const DEEP = {
  code: "recipe.deep",
  gravity: "doubt",
  values: { depth_mm: 12.5, usual_mm: 10 },
  sentence: "the depth is 12.5 mm, and more than 10 mm is unusual",
};
const ASKS = {
  code: "recipe.edit.asks",
  gravity: "fault",
  values: { number: 2, edit: "load: at = [1.0, 2.0, 3.0]", concerns: [PUT, DEEP], words: ["load on tibial crest", "depth to 13 mm"] },
};

test("what an edit presses on is sentences in the language chosen", async () => {
  const { setLanguage } = await import("../src/texts");
  const { words } = await import("../src/words");
  const { sentences } = await import("../src/screens/edit-words");
  expect(sentences(PUT)).toBe("The load is put on the tibial crest: bone edge under the skin.");
  setLanguage("de");
  words.value = {
    de: {
      codes: { "recipe.load_on": { says: "Die Belastung liegt auf: {place:term} ({why:term})." }, "recipe.deep": { says: "Die Tiefe ist {depth_mm:g} mm." } },
      terms: { "tibial crest": "Schienbeinkante", "bone edge under the skin": "Knochenkante unter der Haut" },
    },
  };
  expect(sentences(PUT)).toBe("Die Belastung liegt auf: Schienbeinkante (Knochenkante unter der Haut).");
  expect(sentences(DEEP)).toBe("Die Tiefe ist 12,5 mm.");
});

test("a refusal for want of a word is told by what it is about; another refusal is not taken for one", async () => {
  const { askedBy } = await import("../src/screens/edit-words");
  const asked = {
    what: "The load is put on the tibial crest: bone edge under the skin. The depth is 12.5 mm, and more than 10 mm is unusual.",
    words: ["load on tibial crest", "depth to 13 mm"],
  };
  expect(askedBy(ASKS)).toEqual(asked);
  expect(askedBy({ code: "recipe.not_added", gravity: "fault", values: { reason: { ...ASKS, code: "recipe.asks" } } })).toEqual(asked);
  expect(
    askedBy({
      code: "recipe.edit.refused",
      gravity: "fault",
      values: { number: 2, edit: "load", reason: { code: "edit.unsound", gravity: "fault", values: {} } },
    }),
  ).toBeNull();
  expect(askedBy(null)).toBeNull();
});

test("the scan has its sock on or off only as it is recorded", async () => {
  const { scanWords } = await import("../src/screens/edit-words");
  const sock = (on: boolean) => [{ kind: "sock", on }];
  expect(scanWords(0, [])).toBe("Against the scan");
  expect(scanWords(0, sock(false))).toBe("Against the scan");
  expect(scanWords(0, sock(true))).toBe("Against the scan, sock still on");
  expect(scanWords(0.3, [])).toBe("Against the scan, sock off");
});

test("a template is called as its file says", async () => {
  const { summaryOf } = await import("../src/screens/edit-words");
  const of = (learned: string) =>
    summaryOf({ number: 1, kind: "from-template", on: true, accept: [], parameters: { learned, strength: 0.5 }, telling: [], text: "" });
  const file = { steps: [{ name: "not this" }], name: 'Knee "new" \u00e4' };
  expect(of(JSON.stringify(file))).toMatchObject({ where: 'Knee "new" \u00e4', amount: "50 %" });
  expect(of("no file")).toMatchObject({ where: "" });
});
