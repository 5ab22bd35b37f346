import { beforeEach, expect, test, vi } from "vitest";

beforeEach(() => {
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => undefined });
  vi.stubGlobal("navigator", { language: "de-DE" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: () => {} }));
  vi.resetModules();
});

const found = (code: string, values = {}, english = "") => ({ code, gravity: "fault", values, sentence: english });
const WHY = found("placing.too_few", { placed: 2, count: 9 }, "Only 2 of 9 photos could be joined.");
const ANSWER = {
  go: false,
  headline: found("coach.not_yet", { why: WHY }, "NOT YET: in English"),
  findings: [WHY],
  photos: [{ counts: true }, { counts: false }],
  missing: [],
  board_photos: 5,
  coverage: null,
  notes: [],
  largest_gap_deg: 30,
};

test("what is missing is told in the language chosen, by its figures", async () => {
  const { coachWords, standWords } = await import("../src/screens/coach-words");
  const gap = { count: 2, azimuths_deg: [90, 110], elevations_deg: [10, 10], between: ["a.jpg", "b.jpg"] };
  const said = coachWords({ ...ANSWER, missing: [gap] } as never);
  expect(said.lead).toBe("Noch nicht: 2 weitere Fotos fehlen, wie der Ring zeigt.");
  expect(said.why).toBe("1 Foto zählt nicht.");
  expect(standWords(gap as never, ["Ihr links", "Ihr links"])).toBe("2 zwischen a.jpg und b.jpg: Ihr links.");
});

test("photos that join no other are told as such, with what to do", async () => {
  const { coachWords } = await import("../src/screens/coach-words");
  const photos = [
    { counts: false, placed: false },
    { counts: false, placed: false },
    { counts: true, placed: true, remarks: [] },
  ];
  const said = coachWords({ ...ANSWER, photos } as never);
  expect(said.lead).toBe("Noch nicht: 2 von 3 Fotos hängen mit keinem anderen zusammen.");
  expect(said.why).toMatch(/herumgehen/);
});

test("too few photos of the board and places that too few see are told with their limits", async () => {
  const { coachWords } = await import("../src/screens/coach-words");
  const board = found("coach.board_unseen", { photos: 2, least: 4 });
  expect(coachWords({ ...ANSWER, findings: [board] } as never).lead).toBe("Noch nicht: Das Brett ist in 2 Fotos; 4 sind das Mindeste.");
  const unseen = found("coach.unseen.add", { share: 0.2, least: 3 });
  expect(coachWords({ ...ANSWER, findings: [unseen] } as never).lead).toBe("Noch nicht: 80 % des Gliedmaßes sehen 3 Fotos oder mehr.");
});

test("what is of no usual kind is told in its own words", async () => {
  const { coachWords, remarkWords } = await import("../src/screens/coach-words");
  const { words } = await import("../src/words");
  expect(coachWords(ANSWER as never)).toEqual({ lead: "Noch nicht: Only 2 of 9 photos could be joined.", why: "" });
  words.value = { de: { codes: { "placing.too_few": { says: "Nur {placed} von {count} Fotos.", do: "Herumgehen." } }, terms: {} } };
  expect(coachWords(ANSWER as never)).toEqual({ lead: "Noch nicht: Nur 2 von 9 Fotos.", why: "Herumgehen." });
  expect(coachWords({ ...ANSWER, go: true } as never).lead).toMatch(/^GO/);
  expect(remarkWords(found("photo.blurred"))).toBe("unscharf");
  expect(remarkWords(found("photo.turned"))).toBe("von einem Programm gedreht");
  expect(remarkWords(found("photo.other", {}, "something else"))).toBe("something else");
});

test("a limb that moved and photos that were zoomed are told", async () => {
  const { coachWords } = await import("../src/screens/coach-words");
  expect(coachWords({ ...ANSWER, go: true, kept_still: false } as never).why).toMatch(/Gliedmaß bewegte sich/);
  expect(coachWords({ ...ANSWER, go: true, kept_still: true } as never).why).not.toMatch(/bewegte/);
  expect(coachWords({ ...ANSWER, kept_still: false } as never).lead).toMatch(/bewegte oder beugte sich/);
  const zoomed = found("lens.zoomed", { count: 1, photos: 2 });
  expect(coachWords({ ...ANSWER, findings: [zoomed] } as never).lead).toMatch(/^Noch nicht: 1 Foto/);
});

test("a photo is burnt out where the check says so, and by no limit of the page's own", async () => {
  const { someBurnt } = await import("../src/screens/coach-words");
  const bright = { counts: true, placed: true, burnt: 0.1, remarks: [] };
  const burnt = { counts: false, placed: true, burnt: 0.5, remarks: [found("photo.overexposed", { share: 0.5 })] };
  expect(someBurnt([bright] as never)).toBe(false);
  expect(someBurnt([bright, burnt] as never)).toBe(true);
});

test("a tile says shortly what is wrong with a photo, or that there is a remark", async () => {
  const { remarkInShort } = await import("../src/screens/coach-words");
  expect(remarkInShort(found("photo.blurred"))).toBe("unscharf");
  expect(remarkInShort(found("photo.new_one", {}, "A sentence of v1.5, with stops: many."))).toBe("siehe Hinweis");
});
