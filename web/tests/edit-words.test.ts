import { beforeEach, expect, test, vi } from "vitest";

beforeEach(() => {
  const kept = new Map<string, string>();
  vi.stubGlobal("localStorage", { getItem: (k: string) => kept.get(k) ?? null, setItem: (k: string, v: string) => kept.set(k, v) });
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { lang: "" } });
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: () => {} }));
  vi.resetModules();
});

const PUT = "the load is put on the tibial crest: bone edge under the skin";
const MEANT = "A load carves the positive in, so that what is made over it presses there; for room use relieve. If it is meant, say so:";

test("what an edit presses on is said in the language chosen", async () => {
  const { setLanguage } = await import("../src/texts");
  const { concernOf } = await import("../src/screens/edit-words");
  const says = (what: string) => concernOf({ what, word: "" });
  expect(says(PUT)).toBe("The load is put on the tibial crest: bone edge under the skin.");
  setLanguage("de");
  expect(says(PUT)).toBe("Die Belastung liegt auf: Schienbeinkante (Knochenkante unter der Haut).");
  expect(says("presses 1.2 mm on the femoral condyle: bone under the skin")).toBe("Sie drückt 1.2\u00a0mm auf: Oberschenkelknorren (Knochen unter der Haut).");
  expect(says("presses on fibula head 0.5 mm, tibia end 1.0 mm")).toBe("Es drückt, wo kein Druck vertragen wird: Wadenbeinköpfchen 0.5\u00a0mm, Schienbeinende 1.0\u00a0mm.");
  expect(says("the depth is 12 mm, and more than 10 mm is unusual")).toBe("Die Tiefe ist 12\u00a0mm; mehr als 10\u00a0mm ist ungewöhnlich.");
  expect(says("with the edits before it the surface lies 11.5 mm inside the scan, and more than 10 mm is unusual")).toContain("11.5\u00a0mm innerhalb");
  expect(says("a sentence of a later server")).toBe("a sentence of a later server");
});

test("a refusal for want of a word is told by what it is about; another refusal is not taken for one", async () => {
  const { wordLacks } = await import("../src/screens/edit-words");
  const edit = "Edit 2 (load: at = [1.0, 2.0, 3.0], depth_mm = 3):";
  expect(wordLacks(`${edit} ${PUT}. ${MEANT} "load on tibial crest".`)).toBe("The load is put on the tibial crest: bone edge under the skin.");
  expect(wordLacks(`${edit} ${PUT}; the depth is 12 mm, and more than 10 mm is unusual. ${MEANT} "load on tibial crest".`)).toContain("The depth is 12\u00a0mm");
  expect(wordLacks(`${edit} The load was not done: 3 pairs of triangles would fold over.`)).toBeNull();
});

test("the scan has its sock on or off only as it is recorded", async () => {
  const { scanWords } = await import("../src/screens/edit-words");
  const sock = (on: boolean) => [{ kind: "sock", on }];
  expect(scanWords(0, [])).toBe("Against the scan");
  expect(scanWords(0, sock(false))).toBe("Against the scan");
  expect(scanWords(0, sock(true))).toBe("Against the scan, sock still on");
  expect(scanWords(0.3, [])).toBe("Against the scan, sock off");
});
