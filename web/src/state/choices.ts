/** What was chosen for computing a case, kept by this browser until it is sent with the run. */
import { signal } from "@preact/signals";

import type { Schemas } from "../api/client";

export interface Choices {
  readonly cameras: readonly string[];
  readonly board: "printed" | "none" | Schemas["BoardSpec"];
  readonly poisson: boolean;
  readonly unscaled: boolean;
}

const NONE: Choices = { cameras: [], board: "printed", poisson: false, unscaled: false };
const changed = signal(0);
const key = (caseId: string) => `limbgram.choices.${caseId}`;

export function choicesOf(caseId: string): Choices {
  void changed.value;
  const kept = localStorage.getItem(key(caseId));
  return kept ? { ...NONE, ...(JSON.parse(kept) as Partial<Choices>) } : NONE;
}

export function keepChoices(caseId: string, next: Choices): void {
  localStorage.setItem(key(caseId), JSON.stringify(next));
  changed.value++;
}

const PRINTED: Schemas["BoardSpec"] = { kind: "charuco", columns: 7, rows: 5, square_mm: 30, marker_mm: 22, dictionary: "4X4_50" };

/** The board as the server wants it: null looks for none. */
export function boardOf(caseId: string): Schemas["BoardSpec"] | null {
  const { board } = choicesOf(caseId);
  return board === "none" ? null : board === "printed" ? PRINTED : board;
}
