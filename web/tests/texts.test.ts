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

test("sizes and times are short, and a time left never counts below zero", async () => {
  const { bytes, duration } = await import("../src/texts");
  expect(bytes(612_000_000)).toBe("612 MB");
  expect(bytes(4_100_000)).toBe("4.1 MB");
  expect(duration(-3)).toBe("0 s");
  expect(duration(400)).toBe("7 min");
});
