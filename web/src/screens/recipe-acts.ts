/**
 * Changes of a recipe that are on their way to the server, and the list of edits as it is after them.
 *
 * An edit is called by its number, so the list shows at once what a change makes of the numbers: the next
 * press means what it shows. A recipe that is asked for while an answer is late or lost may have that
 * change in it already: it names the act that made it. Each change also says on which recipe it was made;
 * the server refuses it on any other one.
 */
import type { Schemas } from "../api/client";
import { type Act, pending } from "../state/acts";

export const RECIPE = "/api/v1/cases/{case_id}/recipe";
export const EDITS = `${RECIPE}/edits` as const;
export const EDIT = `${RECIPE}/edits/{number}` as const;

/** An edit as it is shown, with the number that it has in the ledger; null: that is not known yet. */
export type Shown = Schemas["EditReply"] & { readonly was: number | null };

/** The changes of a case's recipe that are pending. */
export const recipeActs = (caseId: string): readonly Act[] =>
  pending.value.filter((one) => one.path.startsWith(RECIPE) && one.init.params?.path?.["case_id"] === caseId);

/** The recipe on which the next change is made: what the last pending one makes, else what the server said. */
export const seenBy = (acts: readonly Act[], mark: string | undefined): string | undefined => acts[acts.length - 1]?.id ?? mark;

/** The edits of a recipe once the acts are done; null where that cannot be told before the answer, as of undo. */
export function afterActs(
  recipe: Pick<Schemas["RecipeReply"], "edits" | "act">,
  acts: readonly Pick<Act, "id" | "method" | "path" | "init">[],
): readonly Shown[] | null {
  let list: Shown[] = recipe.edits.map((one) => ({ ...one, was: one.number }));
  const done = acts.findIndex((one) => one.id === recipe.act);
  for (const { method, path, init } of acts.slice(done + 1)) {
    if (path === EDITS) continue; // it comes at the end, once the server has done it
    if (path !== EDIT) return null;
    const at = Number(init.params?.path?.["number"]) - 1;
    if (!list[at]) return null;
    const change = (init.body ?? {}) as Schemas["EditChange"];
    const one: Shown = {
      ...list[at],
      ...(typeof change.on === "boolean" && { on: change.on }),
      ...(change.parameters && { parameters: change.parameters as Shown["parameters"], was: null }),
    };
    const others = list.filter((_, i) => i !== at);
    list = method === "delete" ? others : others.toSpliced((change.number ?? at + 1) - 1, 0, one);
  }
  return list.map((one, i) => ({ ...one, number: i + 1 }));
}

/** The number of an edit after one, which may be another, was moved from its number to a new one. */
export function movedTo(number: number, from: number, to: number): number {
  if (number === from) return to;
  const left = number > from ? number - 1 : number;
  return left >= to ? left + 1 : left;
}
