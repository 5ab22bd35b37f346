/** The recipe with its ledger as the server has it, and the list of edits once the pending changes are done. */
import { type Schemas, api, taken } from "../../api/client";
import { type Asked, useAsked } from "../../state/asked";
import { type Shown, afterActs, recipeActs } from "../recipe-acts";
import type { Room } from "../room";

export type Ledgered = Schemas["Ledgered"];

export interface Ledger {
  readonly asked: Asked<Ledgered>;
  readonly book: Ledgered | null;
  /** Null where the list cannot be told before the answer. */
  readonly listed: readonly Shown[] | null;
}

export function useLedger(room: Room): Ledger {
  const asked = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/recipe/ledger", { params: { path: { case_id: room.id } } })), [room.id, room.news.work]);
  const book = asked.value.value;
  const going = recipeActs(room.id);
  return { asked, book, listed: book && afterActs(book.recipe, going) };
}

/** By how much an edit changed the volume, mL; null where it is not comparable. */
export function changed(volume: Schemas["VolumeChange"] | null | undefined): number | null {
  return volume ? volume.after_ml - volume.before_ml : null;
}
