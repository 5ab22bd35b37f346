import { beforeEach, expect, test, vi } from "vitest";

beforeEach(() => {
  const kept = new Map<string, string>();
  vi.stubGlobal("localStorage", { getItem: (k: string) => kept.get(k) ?? null, setItem: (k: string, v: string) => kept.set(k, v) });
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.resetModules();
});

test("a text takes what is put in, counts one as one, and speaks both languages", async () => {
  const { setLanguage, t } = await import("../src/texts");
  setLanguage("en");
  expect(t("state.edits", 1)).toBe("1 edit");
  expect(t("state.edits", 8)).toBe("8 edits");
  expect(t("capture.of", 17, 18)).toBe("17 of 18 photos are here");
  setLanguage("de");
  expect(t("state.edits", 8)).toBe("8 Änderungen");
});

test("one of a thing is told as one in both languages", async () => {
  const { LANGUAGES, setLanguage, t } = await import("../src/texts");
  const counted = ["capture.here", "capture.coming", "capture.checking", "coach.board", "cases.disk", "measure.conflicts", "point.photos"] as const;
  for (const language of Object.keys(LANGUAGES) as (keyof typeof LANGUAGES)[]) {
    setLanguage(language);
    for (const key of counted) expect(t(key, 1, 1)).not.toMatch(/1 (photos|Fotos|Fällen|Werte|readings)/);
  }
});
