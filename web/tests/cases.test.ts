import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

test("a kind without sides is asked for none, and keeps none that was chosen before", async () => {
  const { limbKinds } = await import("../src/limb-kinds");
  const { lacksOf, sideOf } = await import("../src/screens/cases/fields");
  limbKinds.value = [
    { kind: "torso", sided: false, words: { en: "Trunk" } },
    { kind: "foot", sided: true, words: { en: "Foot" } },
  ] as never;
  expect(lacksOf(null, null)).toBe("Which side of the patient is the limb?");
  expect(lacksOf(null, "foot")).toBe("Which side of the patient is the limb?");
  expect(lacksOf("left", null)).toBe("Which kind of limb?");
  expect(lacksOf("left", "foot")).toBeNull();
  expect(lacksOf(null, "torso")).toBeNull();
  expect(sideOf("left", "torso")).toBeNull();
  expect(sideOf("left", "foot")).toBe("left");
});
