import { signal } from "@preact/signals";
import { beforeEach, expect, test, vi } from "vitest";

import { json, stubBrowser } from "./browser";
import { running } from "./hook";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

test("a file of a shape that another window changed is written anew, and its picture is looked at anew", async () => {
  let written = 0;
  vi.stubGlobal("fetch", async (request: Request) => json(request.method === "POST" ? { name: `file ${++written}` } : []));
  const { useExport } = await import("../src/screens/send/export");
  const openCase = { id: "K7Q-4F2", info: { side: "left", kind: "transtibial", verdict: { light: "green" } }, changes: {} };
  const tag = signal<string | null>(null);
  const made = await running(() => useExport(openCase as never, tag.value));
  tag.value = "one";
  made.now.write({ side: "left" });
  await made.rest();
  expect(made.now.written.value?.name).toBe("file 1");
  made.now.held.value = true;
  tag.value = "another";
  await made.rest();
  expect(made.now.written.value?.name).toBe("file 2");
  expect(made.now.held.value).toBe(false);
});
