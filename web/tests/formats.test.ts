import { beforeEach, expect, test, vi } from "vitest";

beforeEach(() => {
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => {} });
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
});

test("what is usual of a kind of file, and its limits, are the server's", async () => {
  const { exportKinds, limitsOf, usualOf } = await import("../src/formats");
  expect(usualOf("aop", "spokes")).toBeUndefined();
  const field = { name: "spokes", expected: "int", meaning: "", unit: "", needed: false, above: false, choices: [], several: false };
  exportKinds.value = [
    { kind: "aop", used_for: {}, everyday: true, mesh: false, fields: [{ ...field, default: null, usual: 96, least: 8, most: 3600 }] },
    { kind: "dxf", used_for: {}, everyday: true, mesh: false, fields: [{ ...field, name: "spacing_mm", default: 0 }] },
  ];
  expect(usualOf("aop", "spokes")).toBe(96);
  expect(usualOf("dxf", "spacing_mm")).toBe(0);
  expect(limitsOf("aop", "spokes")).toEqual({ min: 8, max: 3600 });
  expect(limitsOf("dxf", "spacing_mm")).toEqual({});
});
