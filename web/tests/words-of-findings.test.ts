import { beforeEach, expect, test, vi } from "vitest";

import SHARED from "../../tests/data/words.json";
import type { Value } from "../src/words";

beforeEach(() => {
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => undefined });
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.resetModules();
});

test.each(["en", "de"] as const)("templates are filled as the program fills them: %s", async (spoken) => {
  const { setLanguage } = await import("../src/texts");
  const { filled, words } = await import("../src/words");
  setLanguage(spoken);
  words.value = { [spoken]: { codes: { "said.as_is": { says: "{message}" } }, terms: SHARED.terms[spoken] } };
  for (const one of SHARED.cases) expect(filled(one.template, one.values as unknown as Record<string, Value>)).toBe(one[spoken]);
});

test("a finding is told with its advice; without words of its code its English sentence stands", async () => {
  const { setLanguage } = await import("../src/texts");
  const { told, words } = await import("../src/words");
  setLanguage("de");
  words.value = { de: { codes: { "edit.deep": { says: "Die Tiefe ist {depth_mm:.1f} mm.", do: "Prüfen." } }, terms: {} } };
  expect(told({ code: "edit.deep", gravity: "doubt", values: { depth_mm: 12 } })).toBe("Die Tiefe ist 12,0 mm. Prüfen.");
  expect(told({ code: "edit.other", gravity: "note", values: {}, sentence: "It is other." })).toBe("It is other.");
});

test("a title says what, and the text below it why and what to do; what hands on another is parted as that", async () => {
  const { setLanguage } = await import("../src/texts");
  const { inParts, told, words } = await import("../src/words");
  setLanguage("en");
  const codes = {
    "edit.thin": { says: "It is thin (e.g. {least_mm:g} mm).", why: "The file says so.", do: "Thicken it." },
    "verdict.doubtful": { says: "{first}", why: "{count:One more.|{count} more.}" },
  };
  words.value = { en: { codes, terms: {} } };
  const thin = { code: "edit.thin", gravity: "fault", values: { least_mm: 1.5 } };
  expect(inParts(thin)).toEqual({ what: "It is thin (e.g. 1.5 mm).", more: "The file says so. Thicken it." });
  const verdict = { code: "verdict.doubtful", gravity: "doubt", values: { first: thin, count: 2 } };
  expect(inParts(verdict)).toEqual({ what: "It is thin (e.g. 1.5 mm).", more: "The file says so. Thicken it. 2 more." });
  for (const one of [thin, verdict]) expect(Object.values(inParts(one)).join(" ")).toBe(told(one));
  expect(inParts({ code: "edit.other", gravity: "note", values: {}, sentence: "It is other. So." })).toEqual({ what: "It is other. So.", more: "" });
});
