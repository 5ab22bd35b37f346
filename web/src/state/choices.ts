/**
 * What was chosen for computing a case, kept by this browser until it is sent with the run.
 *
 * What the ruler of the printed board reads is of the print: cases go by the last good reading, until they are
 * computed or have a reading of their own.
 */
import { signal } from "@preact/signals";

import type { Schemas } from "../api/client";
import figures from "../api/figures.json";

export interface Choices {
  readonly cameras: readonly string[];
  readonly board: "printed" | "none" | Schemas["BoardSpec"];
  readonly poisson: boolean;
  readonly unscaled: boolean;
  /** What a steel rule reads on the ruler that is printed with the board; null: as last typed in any case. */
  readonly ruler_mm: number | null;
  /** A girth taped on the limb; null where nobody taped one. */
  readonly tape: { readonly height_mm: number | null; readonly girth_mm: number | null } | null;
}

/** How long that ruler was drawn, and how far off a print may be, as a share: beyond, the rule was misread. */
export const { RULER_MM, RULER_MOST_OFF } = figures;
const RULER_KEY = "limbgram.ruler";

const NONE: Choices = { cameras: [], board: "printed", poisson: false, unscaled: false, ruler_mm: null, tape: null };
const changed = signal(0);
addEventListener("storage", () => changed.value++); // another window chose
const key = (caseId: string) => `limbgram.choices.${caseId}`;

export function choicesOf(caseId: string): Choices {
  void changed.value;
  const kept = localStorage.getItem(key(caseId));
  return kept ? { ...NONE, ...(JSON.parse(kept) as Partial<Choices>) } : NONE;
}

/** Keep some choices; the others stay as they are, also where another window made them meanwhile. */
export function keepChoices(caseId: string, part: Partial<Choices>): void {
  const before = choicesOf(caseId);
  const next = { ...before, ...part };
  const typed = next.ruler_mm !== null && next.ruler_mm !== before.ruler_mm;
  localStorage.setItem(key(caseId), JSON.stringify(next));
  if (typed && !rulerFar(rulerOf(next))) localStorage.setItem(RULER_KEY, String(next.ruler_mm));
  changed.value++;
}

/** What the ruler of the print reads, mm. */
export const rulerOf = ({ ruler_mm }: Choices) => ruler_mm ?? Number(localStorage.getItem(RULER_KEY) ?? RULER_MM);

/** Whether no print of the board can be so large or so small. */
export const rulerFar = (ruler_mm: number) => !(Math.abs(ruler_mm / RULER_MM - 1) <= RULER_MOST_OFF);

/** Whether a taped girth was begun and is not whole. */
export const tapeLacks = ({ board, tape }: Choices) => board !== "none" && tape !== null && !(tape.height_mm !== null && tape.girth_mm);

/** The taped girths as the server wants them; without a size there is nothing to hold them against. */
export function tapesOf({ board, tape }: Choices): Schemas["Tape"][] {
  return board === "none" || !tape?.girth_mm || tape.height_mm === null ? [] : [{ height_mm: tape.height_mm, girth_mm: tape.girth_mm }];
}

/** The board that the program prints. */
export const PRINTED = { ...figures.PRINTED_BOARD, ruler: null } as Schemas["BoardSpec"];

/** The board as the server wants it: null looks for none. */
export function boardOf(caseId: string): Schemas["BoardSpec"] | null {
  const choices = choicesOf(caseId);
  const { board } = choices;
  return board === "none" ? null : board === "printed" ? { ...PRINTED, ruler: { drawn_mm: RULER_MM, measured_mm: rulerOf(choices) } } : board;
}

/** What is computed, as the server wants it: without a size only where no board tells one. */
export function jobOf(caseId: string): Schemas["JobOptions"] {
  const choices = choicesOf(caseId);
  return {
    cameras: [...choices.cameras],
    board: boardOf(caseId),
    surface: choices.poisson ? "poisson" : "ball-pivoting",
    unscaled: choices.board === "none" && choices.unscaled,
    distances: [],
    tapes: tapesOf(choices),
    triangles: 500_000,
  };
}
