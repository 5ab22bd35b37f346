import { beforeEach, expect, test, vi } from "vitest";

import { json, stubBrowser } from "./browser";

/** What the server does with each piece, in order: a status, and what it answers. */
let pieces: { readonly status: number; readonly answer: unknown }[];

class Sender {
  upload = {};
  status = 0;
  response: unknown = null;
  onload = () => {};
  open() {}
  setRequestHeader() {}
  send() {
    ({ status: this.status, answer: this.response } = pieces.shift()!);
    queueMicrotask(() => this.onload());
  }
}

beforeEach(() => {
  stubBrowser();
  vi.useFakeTimers();
  vi.stubGlobal("XMLHttpRequest", Sender);
  vi.stubGlobal("fetch", async () => json({ photos: [] }));
  vi.resetModules();
});

const photo = () => new File(["0123456789"], "A.jpg");
const WHOLE = { status: 200, answer: { whole: true, bytes: 10, photos: [] } };

async function sentOf(answers: typeof pieces) {
  pieces = answers;
  const { send, uploads } = await import("../src/state/uploads");
  send("K7Q-4F2", [photo()], () => {});
  await vi.advanceTimersByTimeAsync(10_000);
  return uploads.value.get("K7Q-4F2")![0];
}

test("a photo that comes while the page is locked waits for the password, and then goes on", async () => {
  expect(await sentOf([{ status: 423, answer: null }, WHOLE])).toMatchObject({ state: "here" });
});

test("a photo that the server refuses is refused", async () => {
  expect(await sentOf([{ status: 422, answer: { kind: "Photo", message: "No photo." } }])).toMatchObject({ state: "refused", message: "No photo." });
});

test("a photo whose case is gone once the line is back is refused, and waits no longer", async () => {
  vi.stubGlobal("fetch", async () => json({ kind: "Missing", message: "No such case." }, 404));
  expect(await sentOf([{ status: 503, answer: null }])).toMatchObject({ state: "refused", message: "No such case." });
});

test("what was refused is not on its way, and what the server holds is neither", async () => {
  const { outstanding, uploads } = await import("../src/state/uploads");
  const one = (name: string, state: string) => ({ name, total: 1, sent: 0, state, message: "" }) as never;
  uploads.value = new Map([["K7Q-4F2", [one("a", "sending"), one("b", "refused"), one("c", "here"), one("d", "sending"), one("e", "offline")]]]);
  const { onTheirWay, refused } = outstanding("K7Q-4F2", [{ name: "d" }]);
  expect(onTheirWay.map(({ name }) => name)).toEqual(["a", "e"]);
  expect(refused.map(({ name }) => name)).toEqual(["b"]);
});

test("photos of one name in two folders are two, and the same photo dropped twice is one", async () => {
  const { send, uploads } = await import("../src/state/uploads");
  const [front, back] = [new File(["0123456789"], "IMG_1.jpg", { lastModified: 1 }), new File(["0123456789"], "IMG_1.jpg", { lastModified: 2 })];
  pieces = [WHOLE, WHOLE];
  send("K7Q-4F2", [front, back, front], () => {});
  await vi.advanceTimersByTimeAsync(10_000);
  expect(uploads.value.get("K7Q-4F2")).toMatchObject([
    { name: "IMG_1.jpg", state: "here" },
    { name: "IMG_1-2.jpg", state: "here" },
  ]);
  expect(pieces).toEqual([]);
});
