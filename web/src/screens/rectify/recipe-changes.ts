/** Changes of the recipe: each is an act; the ledger comes back with it, then the shape. */
import { Refused, type Schemas } from "../../api/client";
import { perform } from "../../state/acts";
import { useAct } from "../../state/requests";
import { EDIT, EDITS, RECIPE, recipeActs, seenBy } from "../recipe-acts";
import type { OpenCase } from "../open-case";
import type { Base } from "./base";
import type { EditBody } from "./draft";
import type { Ledger, Ledgered } from "./ledger";
import type { Keeping } from "./open-edit";
import type { Trial } from "./trial";

export interface RecipeChanges {
  /** Why the last one was refused. */
  readonly refused: Refused | null;
  /** Whether this very edit was kept: one is kept after the other. */
  readonly add: (body: EditBody) => Promise<boolean>;
  readonly undo: () => void;
  readonly redo: () => void;
  readonly change: (number: number, body: Schemas["EditChange"]) => void;
  readonly remove: (number: number) => void;
}

interface Context {
  readonly ledger: Ledger;
  readonly base: Base;
  readonly trial: Trial;
  readonly keeping: Keeping;
  readonly drop: () => void;
  /** Ask for the limb after the recipe. */
  readonly again: () => Promise<void>;
}

export function useRecipeChanges(openCase: OpenCase, { ledger, base, trial, keeping, drop, again }: Context): RecipeChanges {
  const act = useAct();
  const { asked, book } = ledger;
  const path = { case_id: openCase.id };

  /** On the recipe that is shown: the server refuses it on any other one. */
  const run = (call: (query: { seen?: string }) => Promise<unknown>) =>
    act.run(async () => {
      try {
        await call({ seen: seenBy(recipeActs(openCase.id), book?.recipe.mark) });
      } catch (error) {
        if (error instanceof Refused && error.status === 409) void asked.again();
        throw error;
      }
      await again();
      await openCase.again();
    });
  const took = (answer: Ledgered, sent_ms: number) => {
    const overtaken = asked.askedSince(sent_ms); // another window may have changed since
    base.carry(null);
    asked.put(answer);
    if (overtaken) void asked.again();
  };
  const tookAnew = async () => {
    await asked.again();
    base.carry(null);
  };
  const ways = { done: took, again: tookAnew };

  const add = async (body: EditBody): Promise<boolean> => {
    if (keeping.now.value) return false;
    keeping.now.value = true;
    const kept = (tried_mm: Float32Array | null) => {
      base.carry(tried_mm);
      keeping.now.value = false;
      drop();
    };
    const done = (answer: Ledgered, sent_ms: number) => {
      const tried_mm = trial.tried.value?.values ?? null;
      took(answer, sent_ms);
      kept(tried_mm);
    };
    const anew = () => tookAnew().then(() => kept(null));
    const added = await run(() => perform(openCase.id, "post", EDITS, { params: { path }, body }, { id: keeping.offer.idOf(body), done, again: anew }));
    keeping.now.value = false;
    return added !== null;
  };

  return {
    refused: act.refused.value,
    add,
    undo: () => void run((query) => perform(openCase.id, "post", `${RECIPE}/undo`, { params: { path, query } }, ways)),
    redo: () => void run((query) => perform(openCase.id, "post", `${RECIPE}/redo`, { params: { path, query } }, ways)),
    change: (number, body) => void run((query) => perform(openCase.id, "patch", EDIT, { params: { path: { ...path, number }, query }, body }, ways)),
    remove: (number) => void run((query) => perform(openCase.id, "delete", EDIT, { params: { path: { ...path, number }, query } }, ways)),
  };
}
