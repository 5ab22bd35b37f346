import { beforeEach, expect, test, vi } from "vitest";

import { stubBrowser } from "./browser";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

const ANSWER = { go: true, headline: { code: "coach.go", gravity: "note", values: {} }, findings: [], photos: [], missing: [], notes: [], coverage: null };
const said = (own: object) => ({ state: "done", current: true, photos: 18, finding: null, answer: ANSWER, ...own }) as never;
const CASE = { state: "photos", sample: false } as never;

test("the patient may go by the answer for the photos that are here, and by no other", async () => {
  const { bannerWords, goes } = await import("../src/screens/capture/banner-words");
  expect(bannerWords(said({}), CASE, 18)).toMatchObject({ lead: "GO. The patient may leave.", tone: "green", icon: "tick" });
  const old = said({ current: false });
  expect(goes(old)).toBe(false);
  const words = bannerWords(old, CASE, 19);
  expect(words).toMatchObject({ tone: "amber", icon: "warn" });
  expect(words.lead).not.toMatch(/GO/);
  expect(words.why).toBe("The patient stays until they are checked again.");
});

test("the ring says no GO either of photos that were not checked", async () => {
  const { checkWords } = await import("../src/screens/coach-words");
  expect(checkWords({ current: false }, ANSWER as never).lead).toBe("Photos came or went since the check.");
  expect(checkWords({ current: true }, ANSWER as never).lead).toMatch(/^GO/);
});

test("what is going on is told before what was answered", async () => {
  const { bannerWords } = await import("../src/screens/capture/banner-words");
  expect(bannerWords(null, CASE, 0).lead).toBe("Put the photos of the walk-round here.");
  expect(bannerWords(null, CASE, 4)).toMatchObject({ lead: "Photos are arriving.", tone: "" });
  expect(bannerWords(said({ state: "running", current: false }), CASE, 18)).toMatchObject({ lead: "Looking at 18 photos.", tone: "" });
  expect(bannerWords(said({ state: "refused", answer: null }), CASE, 18)).toMatchObject({ lead: "Not yet: the photos cannot be judged.", tone: "amber" });
  expect(bannerWords(said({}), { state: "computing" } as never, 18).lead).toBe("The shape is being computed.");
  expect(bannerWords(null, { state: "finished" } as never, 18)).toMatchObject({ lead: "The shape is computed.", tone: "green", rests: true });
});
