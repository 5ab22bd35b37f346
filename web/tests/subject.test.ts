import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";
import { running } from "./hook";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

async function subjectOf(info: object, reply: object) {
  vi.doMock("../src/screens/limb", () => ({ useLimb: () => ({ limb: { reply }, asked: {} }) }));
  const { useSubject } = await import("../src/screens/align/subject");
  return (await running(() => useSubject({ id: "K7Q-4F2", info } as never))).now;
}

test("a side and a kind that are said anew of an aligned case are those that it is aligned with again", async () => {
  const made = await subjectOf({ side: "right", kind: "transfemoral" }, { aligned: true, side: "left", kind: "transtibial" });
  expect(made.side).toBe("right");
  expect(made.kind).toBe("transfemoral");
});

test("a case that says neither has those of its limb", async () => {
  const made = await subjectOf({ side: null, kind: null }, { aligned: true, side: "left", kind: "foot" });
  expect(made.side).toBe("left");
  expect(made.kind).toBe("foot");
});
