import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";
import { running } from "./hook";

let coming: Map<string, (file: Response) => void>;

beforeEach(() => {
  stubBrowser();
  coming = new Map();
  vi.stubGlobal("fetch", (url: string) => new Promise<Response>((go) => coming.set(/templates\/(\w+)\//.exec(url)![1], go)));
  vi.resetModules();
});

async function choosing() {
  const { useChosen } = await import("../src/screens/templates/chosen");
  const tried: unknown[] = [];
  const isReadable = (id: string) => ["first", "second"].includes(id);
  const run = async <T>(act: () => Promise<T>) => await act();
  const made = await running(() => useChosen({ run } as never, isReadable, (edit) => void tried.push(edit.parameters)));
  return { made, tried };
}

test("a template whose file comes late is not tried in the place of the one that was chosen since", async () => {
  const { made, tried } = await choosing();
  made.now.id.value = "first";
  await made.rest();
  made.now.id.value = "second";
  await made.rest();
  coming.get("second")!(new Response("file 2"));
  await made.rest();
  coming.get("first")!(new Response("file 1"));
  await made.rest();
  expect(tried).toEqual([{ learned: "file 2", strength: 1 }]);
  expect((await made.now.edit()).parameters).toEqual({ learned: "file 2", strength: 1 });
});

test("a template that was left before its file came is not tried", async () => {
  const { made, tried } = await choosing();
  made.now.id.value = "first";
  await made.rest();
  await made.leave();
  coming.get("first")!(new Response("file 1"));
  await made.rest();
  expect(tried).toEqual([]);
});

test("a template whose file is damaged is neither fetched nor tried", async () => {
  const { made, tried } = await choosing();
  made.now.id.value = "damaged";
  await made.rest();
  expect(coming.size).toBe(0);
  expect(tried).toEqual([]);
});
