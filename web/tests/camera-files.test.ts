import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

test("photos of the board that a phone calls all alike are told apart, as those of a case are", async () => {
  const { placeOf } = await import("../src/screens/camera-files");
  const taken = [1_700_000_000_000, 1_700_000_003_000].map((lastModified) => placeOf("abcd2345", { name: "image.jpg", lastModified }));
  expect(new Set(taken).size).toBe(2);
  expect(taken[0]).toMatch(/^\/cameras\/abcd2345\/photos\/photo-\d{17}\.jpg$/);
  expect(placeOf("abcd2345", { name: "lens.JSON", lastModified: 1 })).toBe("/cameras/abcd2345/file?name=lens.JSON");
});
