import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

test("a photo that takes the place of another of its name has another picture", async () => {
  const { pictureOf } = await import("../src/screens/photo-picture");
  const [first, second] = ["a1b2c3d4e5", "f6a7b8c9d0"].map((sha256) => pictureOf("K7Q-4F2", { name: "Fuß 1.jpg", sha256 }, 320));
  expect(first).not.toBe(second);
  expect(first).toMatch(/\/photos\/Fu%C3%9F%201\.jpg\/picture\?width=320&/);
});
