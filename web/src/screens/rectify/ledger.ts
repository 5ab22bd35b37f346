/** The recipe with its ledger as the server has it, and the list of edits once the pending changes are done. */
import { type Schemas, answerOf, api } from "../../api/client";
import { type Query, useQuery } from "../../state/requests";
import { type Shown, afterActs, recipeActs } from "../recipe-acts";
import type { OpenCase } from "../open-case";

export type Ledgered = Schemas["Ledgered"];

export interface Ledger {
  readonly asked: Query<Ledgered>;
  readonly book: Ledgered | null;
  /** Null where the list cannot be told before the answer. */
  readonly listed: readonly Shown[] | null;
}

export function useLedger(openCase: OpenCase): Ledger {
  const asked = useQuery(
    () => answerOf(api.GET("/api/v1/cases/{case_id}/recipe/ledger", { params: { path: { case_id: openCase.id } } })),
    [openCase.id, openCase.changes.work],
  );
  const book = asked.value.value;
  const going = recipeActs(openCase.id);
  return { asked, book, listed: book && afterActs(book.recipe, going) };
}

/** By how much an edit changed the volume, mL; null where it is not comparable. */
export function changed(volume: Schemas["VolumeChange"] | null | undefined): number | null {
  return volume ? volume.after_ml - volume.before_ml : null;
}
