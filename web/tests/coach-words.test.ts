import { beforeEach, expect, test, vi } from "vitest";

beforeEach(() => {
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => undefined });
  vi.stubGlobal("navigator", { language: "de-DE" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: () => {} }));
  vi.resetModules();
});

const ANSWER = { go: false, headline: "NOT YET: in English", findings: [], photos: [{ counts: true }, { counts: false }], missing: [], board_photos: 5, coverage: null, notes: [], largest_gap_deg: 30 };

test("what is missing is told in the language chosen, by its figures", async () => {
  const { coachWords, standWords } = await import("../src/screens/coach-words");
  const gap = { count: 2, azimuths_deg: [90, 110], elevations_deg: [10, 10], between: ["a.jpg", "b.jpg"], words: "" };
  const said = coachWords({ ...ANSWER, missing: [gap] } as never);
  expect(said.lead).toBe("Noch nicht: 2 weitere Fotos fehlen, wie der Ring zeigt.");
  expect(said.why).toBe("1 Foto zählt nicht.");
  expect(standWords(gap as never, ["Ihr links", "Ihr links"])).toBe("2 zwischen a.jpg und b.jpg: Ihr links.");
});

test("photos that join no other are told as such, with what to do", async () => {
  const { coachWords } = await import("../src/screens/coach-words");
  const photos = [{ counts: false, placed: false }, { counts: false, placed: false }, { counts: true, placed: true, remarks: [] }];
  const said = coachWords({ ...ANSWER, photos } as never);
  expect(said.lead).toBe("Noch nicht: 2 von 3 Fotos hängen mit keinem anderen zusammen.");
  expect(said.why).toMatch(/herumgehen/);
  const long = coachWords({ ...ANSWER, headline: "NOT YET: the first sentence. What to do." } as never);
  expect(long).toEqual({ lead: "NOT YET: the first sentence.", why: "What to do." });
});

test("what the figures do not tell is the server's own sentence", async () => {
  const { coachWords, remarkWords } = await import("../src/screens/coach-words");
  expect(coachWords(ANSWER as never).lead).toBe("NOT YET: in English");
  expect(coachWords({ ...ANSWER, go: true } as never).lead).toMatch(/^GO/);
  expect(remarkWords("blurred: edges 5 px wide")).toBe("unscharf");
  expect(remarkWords("480 x 720, where 11 others are 720 x 480: a program has turned its pixels by a quarter")).toBe("von einem Programm gedreht");
  expect(remarkWords("something else")).toBe("something else");
});

test("a limb that moved and photos that were zoomed are told", async () => {
  const { coachWords } = await import("../src/screens/coach-words");
  expect(coachWords({ ...ANSWER, go: true, kept_still: false } as never).why).toMatch(/Gliedmaß bewegte sich/);
  expect(coachWords({ ...ANSWER, go: true, kept_still: true } as never).why).not.toMatch(/bewegte/);
  expect(coachWords({ ...ANSWER, kept_still: false } as never).lead).toMatch(/bewegte oder beugte sich/);
  const photos = [{ counts: true, placed: true, remarks: ["Its focal length is longer than that of the other photos, by 4.8%"] }];
  expect(coachWords({ ...ANSWER, photos } as never).lead).toMatch(/^Noch nicht: 1 Foto/);
});
