/** An earlier visit: another case of the same limb, whose places are proposed on this one. */
import { type Signal, useSignal } from "@preact/signals";

import { type Schemas, answerOf, api } from "../../api/client";
import { type Query, useQuery } from "../../state/requests";
import type { Subject } from "./subject";

export interface Visit {
  /** Cases that may be the same limb: of its kind and side, whose places were set. */
  readonly cases: readonly Schemas["Case"][];
  /** Id of the one that is chosen; empty: none. */
  readonly chosen: Signal<string>;
  readonly asked: Query<Schemas["CarriedGuesses"] | null>;
}

export function useVisit({ openCase, limb, kind, side }: Subject): Visit {
  const chosen = useSignal("");
  const others = useQuery(async () => (await answerOf(api.GET("/api/v1/cases", { params: { query: {} } }))).cases, [openCase.id]);
  const asked = useQuery(async () => {
    const path = { case_id: openCase.id, earlier_id: chosen.value };
    return limb && chosen.value ? await answerOf(api.GET("/api/v1/cases/{case_id}/limb/guesses/{earlier_id}", { params: { path } })) : null;
  }, [limb?.reply.sha256, chosen.value, kind, side]);
  const cases = (others.value.value ?? []).filter((one) => one.id !== openCase.id && one.kind === kind && one.side === side && isMarked(one));
  return { cases, chosen, asked };
}

const isMarked = (one: Schemas["Case"]): boolean => one.steps.some((step) => step.name === "align" && step.state === "done");
