import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

const step = (name: string, state: string, count = 0) => ({ name, state, count, front: false });

test("a step that cannot be opened says which one it waits for", async () => {
  const { headOf } = await import("../src/screens/case-head");
  const steps = [
    step("capture", "done", 18),
    step("result", "done"),
    step("align", "open", 2),
    step("measure", "locked"),
    step("rectify", "locked"),
    step("send", "locked"),
    step("record", "locked"),
  ];
  const head = headOf("K7Q-4F2", { kind: "transtibial", side: "left", steps, verdict: { light: "green" } } as never);
  expect(head.steps.capture).toMatchObject({ state: "done", note: "18 photos", needs: "" });
  expect(head.steps.result.note).toBe("Green");
  expect(head.steps.measure).toMatchObject({ state: "later", note: "", needs: "Needs Align first" });
  expect(head.steps.record.needs).toBe("Needs Align first");
});

test("what rests on something that changed is to check", async () => {
  const { headOf } = await import("../src/screens/case-head");
  const head = headOf("K7Q-4F2", { steps: [step("capture", "open"), step("rectify", "check", 3)] } as never);
  expect(head.steps.rectify).toMatchObject({ state: "open", note: "to check", warn: true });
  expect(head.steps.send.state).toBe("later");
});
