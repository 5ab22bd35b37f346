import { signal } from "@preact/signals";
import { expect, test } from "vitest";

import { useLoaded } from "../src/state/loaded";
import { running } from "./hook";

test("a part that comes late takes the place of none that was asked for after it", async () => {
  const coming = new Map<string, (part: string) => void>();
  const load = (name: string) => new Promise<string>((go) => coming.set(name, go));
  const name = signal("result");
  const made = await running(() => useLoaded(name.value, load));
  expect(made.now).toBeNull();
  name.value = "capture";
  await made.rest();
  coming.get("capture")!("the capture");
  await made.rest();
  expect(made.now).toBe("the capture");
  coming.get("result")!("the result");
  await made.rest();
  expect(made.now).toBe("the capture");
});
