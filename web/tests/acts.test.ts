import { beforeEach, expect, test, vi } from "vitest";

type Call = { readonly method: string; readonly url: string; readonly act: string | null; readonly body: string };

let calls: Call[];
/** What the server does with each call, in order; the last one stays. */
let answers: ((call: Call) => Promise<Response> | Response)[];
let kept: Map<string, string>;

const store = () => ({
  getItem: (k: string) => kept.get(k) ?? null,
  setItem: (k: string, v: string) => kept.set(k, v),
  removeItem: (k: string) => kept.delete(k),
});
const json = (body: unknown, status = 200) => new Response(JSON.stringify(body), { status, headers: { "Content-Type": "application/json" } });
const lost = () => Promise.reject(new TypeError("Failed to fetch"));

async function page() {
  vi.resetModules();
  return await import("../src/state/acts");
}

beforeEach(() => {
  calls = [];
  answers = [() => json([])];
  kept = new Map();
  vi.useFakeTimers();
  vi.stubGlobal("location", { origin: "http://127.0.0.1:8000", hash: "" });
  vi.stubGlobal("localStorage", store());
  vi.stubGlobal("sessionStorage", store());
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.stubGlobal("fetch", async (request: Request) => {
    const call = { method: request.method, url: request.url, act: request.headers.get("Act-Id"), body: await request.text() };
    calls.push(call);
    return await (answers.length > 1 ? answers.shift()! : answers[0])(call);
  });
});

const TAPE = "/api/v1/cases/{case_id}/tape";
const read = (height_mm: number, girth_mm: number | null) => ({ params: { path: { case_id: "K7Q-4F2" } }, body: { height_mm, girth_mm } });

test("readings that are typed fast are sent one after the other, each as its own act", async () => {
  const { pending, pendingAt, perform } = await page();
  let first: (answer: Response) => void = () => {};
  answers = [() => new Promise<Response>((go) => (first = go)), () => json([])];
  const done = [
    perform("K7Q-4F2", "patch", TAPE, read(100, 300)),
    perform("K7Q-4F2", "patch", TAPE, read(120, 310)),
    perform("K7Q-4F2", "patch", TAPE, read(100, null)),
  ];
  await vi.advanceTimersByTimeAsync(2000);
  expect(calls).toHaveLength(1);
  expect(pendingAt("K7Q-4F2", TAPE).map((one) => one.init.body)).toEqual([
    { height_mm: 100, girth_mm: 300 },
    { height_mm: 120, girth_mm: 310 },
    { height_mm: 100, girth_mm: null },
  ]);
  expect(pendingAt("another", TAPE)).toEqual([]);
  first(json([]));
  await Promise.all(done);
  expect(calls.map((one) => JSON.parse(one.body).girth_mm)).toEqual([300, 310, null]);
  expect(new Set(calls.map((one) => one.act)).size).toBe(3);
  expect(pending.value).toEqual([]);
  expect(kept.size).toBe(0);
});

test("an act whose answer is lost is sent again under the same id, and is refused only by an answer", async () => {
  const { perform } = await page();
  answers = [lost, () => json({ kind: "Locked", message: "Locked." }, 423), lost, () => json([{ height_mm: 100, girth_mm: 300 }])];
  const done = perform("K7Q-4F2", "patch", TAPE, read(100, 300));
  await vi.advanceTimersByTimeAsync(10_000);
  expect(await done).toEqual([{ height_mm: 100, girth_mm: 300 }]);
  expect(calls).toHaveLength(4);
  expect(new Set(calls.map((one) => one.act)).size).toBe(1);
  answers = [() => json({ kind: "OptionsError", message: "No girth." }, 422)];
  await expect(perform("K7Q-4F2", "patch", TAPE, read(100, 3))).rejects.toThrow("No girth.");
  expect(calls).toHaveLength(5);
});

test("the answer takes the place of what was pending in one moment", async () => {
  const { pending, perform } = await page();
  const seen: number[] = [];
  await perform("K7Q-4F2", "patch", TAPE, read(100, 300), { done: () => seen.push(pending.value.length) });
  expect(seen).toEqual([1]);
  expect(pending.value).toEqual([]);
});

test("an answer of before, given again, is asked for anew", async () => {
  const { pending, perform } = await page();
  answers = [lost, () => new Response("[]", { headers: { "Content-Type": "application/json", "Act-Replayed": "1" } })];
  const taken: string[] = [];
  const ways = {
    done: () => taken.push("answer"),
    again: async () => taken.push(`anew, ${pending.value.length} pending`),
  };
  const both = perform("K7Q-4F2", "patch", TAPE, read(100, 300), ways);
  await vi.advanceTimersByTimeAsync(1000);
  await both;
  expect(taken).toEqual(["anew, 1 pending"]);
  expect(pending.value).toEqual([]);
  answers = [() => json([])];
  await perform("K7Q-4F2", "patch", TAPE, read(100, 300), ways);
  expect(taken).toEqual(["anew, 1 pending", "answer"]);
});

test("an answer that a question overtook is asked for anew: another window may have changed since", async () => {
  const { pending, perform } = await page();
  let answer: (given: Response) => void = () => {};
  answers = [() => new Promise<Response>((go) => (answer = go))];
  for (const asked of [false, true]) {
    const taken: string[] = [];
    const sent: number[] = [];
    const ways = {
      done: () => taken.push("answer"),
      again: async () => taken.push(`anew, ${pending.value.length} pending`),
      askedSince: (moment_ms: number) => sent.push(moment_ms) > 0 && asked,
    };
    const before = performance.now();
    const both = perform("K7Q-4F2", "patch", TAPE, read(100, 300), ways);
    await vi.advanceTimersByTimeAsync(2000);
    answer(json([]));
    await both;
    expect(taken).toEqual([asked ? "anew, 1 pending" : "answer"]);
    expect(sent[0]).toBeGreaterThanOrEqual(before);
    expect(sent[0]).toBeLessThan(before + 1000);
    expect(pending.value).toEqual([]);
  }
});

test("a double Enter is one act", async () => {
  const { newActId, perform } = await page();
  const id = newActId();
  const both = [1, 2].map(() =>
    perform(
      "K7Q-4F2",
      "post",
      "/api/v1/cases/{case_id}/recipe/edits",
      { params: { path: { case_id: "K7Q-4F2" } }, body: { kind: "smoothing", parameters: {}, accept: [], number: null } },
      { id },
    ),
  );
  await Promise.all(both);
  expect(calls.map((one) => one.act)).toEqual([id]);
});

test("what was not answered goes on after a reload under its id, and its refusal is told", async () => {
  const before = await page();
  answers = [() => new Promise<Response>(() => {})];
  void before.perform("K7Q-4F2", "patch", TAPE, read(100, 300)).catch(() => {});
  void before.perform("K7Q-4F2", "patch", TAPE, read(120, 3)).catch(() => {});
  await vi.advanceTimersByTimeAsync(100);
  const ids = before.pending.value.map((one) => one.id);
  const after = await page();
  answers = [() => json([]), () => json({ kind: "OptionsError", message: "No girth." }, 422)];
  after.resumeActs("");
  expect(after.pending.value.map((one) => one.id)).toEqual(ids);
  await vi.advanceTimersByTimeAsync(100);
  expect(calls.slice(1).map((one) => one.act)).toEqual(ids);
  expect(after.missed.value?.message).toBe("No girth.");
  expect(after.pending.value).toEqual([]);
});

test("what one person had not finished goes on for that name alone, and another one is told of it", async () => {
  const before = await page();
  before.resumeActs("Ada");
  answers = [lost];
  void before.perform("K7Q-4F2", "patch", TAPE, read(100, 300)).catch(() => {});
  await vi.advanceTimersByTimeAsync(100);
  before.stopActs(); // Ada signs out: nothing more is sent, and what waits stays
  calls = [];
  await vi.advanceTimersByTimeAsync(60_000);
  expect(calls).toEqual([]);
  const left = kept.get("limbgram.acts") ?? "";

  answers = [() => json([])];
  const hers = await page();
  void hers.perform("M2X-9PD", "patch", TAPE, read(80, 250)).catch(() => {}); // before it is known who is here
  hers.resumeActs("Ada");
  await vi.advanceTimersByTimeAsync(100);
  expect(calls.map((one) => JSON.parse(one.body).girth_mm)).toContain(300);
  expect(calls.map((one) => JSON.parse(one.body).girth_mm)).toContain(250);
  expect(hers.forgotten.value).toEqual([]);

  kept.set("limbgram.acts", left);
  calls = [];
  const his = await page();
  his.resumeActs("Ben");
  await vi.advanceTimersByTimeAsync(100);
  expect(calls).toEqual([]);
  expect(his.pending.value).toEqual([]);
  expect(his.forgotten.value.map((one) => [one.by, one.lane])).toEqual([["Ada", "K7Q-4F2"]]);
  expect(kept.has("limbgram.acts")).toBe(false);
});

test("a form that says something else is another act, and one that says the same is the same until it is done", async () => {
  const { newOffer } = await page();
  const offer = newOffer();
  const left = offer.idOf({ side: "left" });
  expect(offer.idOf({ side: "left" })).toBe(left);
  const right = offer.idOf({ side: "right" });
  expect(right).not.toBe(left);
  expect(offer.idOf({ side: "left" })).not.toBe(left);
  const again = offer.idOf({ side: "left" });
  offer.over();
  expect(offer.idOf({ side: "left" })).not.toBe(again);
});
