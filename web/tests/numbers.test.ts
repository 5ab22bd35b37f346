import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

test("a sign is a true minus, and nothing has none", async () => {
  const { signed } = await import("../src/numbers");
  expect(signed(-2)).toBe("−2.0");
  expect(signed(0.34)).toBe("+0.3");
  expect(signed(-0.04)).toBe("0.0");
});

test("a figure that is not known is a dash", async () => {
  const { fixed, within } = await import("../src/numbers");
  expect([null, undefined, Number.NaN].map((value) => fixed(value, 1))).toEqual(["–", "–", "–"]);
  expect(within(null, 1)).toBe("–");
});

test("what stands behind a ± is never nothing", async () => {
  const { within } = await import("../src/numbers");
  expect(within(0.34, 1)).toBe("0.3");
  expect(within(0.04, 1)).toBe("0.04");
  expect(within(0, 1)).toBe("0.0");
});

test("in German the decimal mark is a comma, in figures and in fields, and both marks are read", async () => {
  const { bytes, fixed, numberIn, signed, typedAs } = await import("../src/numbers");
  const { setLanguage } = await import("../src/texts");
  setLanguage("de");
  expect(fixed(351.24, 1)).toBe("351,2");
  expect(signed(-1.25, 2)).toBe("−1,25");
  expect(typedAs(249.4)).toBe("249,4");
  expect(bytes(4_100_000)).toBe("4,1 MB");
  expect(["249,4", "249.4", "−3", "+2,5", "1e3", "abc", ""].map(numberIn)).toEqual([249.4, 249.4, -3, 2.5, null, null, null]);
});

test("sizes and times are short, and a time left never counts below zero", async () => {
  const { bytes, duration } = await import("../src/numbers");
  expect(bytes(612_000_000)).toBe("612 MB");
  expect(bytes(4_100_000)).toBe("4.1 MB");
  expect(duration(-3)).toBe("0 s");
  expect(duration(400)).toBe("7 min");
});
