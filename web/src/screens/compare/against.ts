/** What a shape is compared with. */
import { t } from "../../texts";

export type Against =
  | { readonly what: "scan" }
  /** The shape before an edit of the recipe, by its number. */
  | { readonly what: "before"; readonly edit: number }
  | { readonly what: "case"; readonly id: string }
  | { readonly what: "file"; readonly name: string };

/** As the server takes it. */
export function asked(against: Against): { case?: string; shape?: string; edits?: number } {
  if (against.what === "case") return { case: against.id };
  if (against.what === "file") return { shape: against.name };
  return against.what === "before" ? { edits: against.edit - 1 } : {};
}

export function wordsFor(against: Against | null): string {
  if (against?.what === "case") return t("compare.case", against.id);
  if (against?.what === "before") return t("compare.before", against.edit);
  return against?.what === "file" ? against.name : t("compare.scan");
}

/** Whether it is an earlier state of this case's own shape. */
export const isOwn = (against: Against | null): boolean => against?.what === "scan" || against?.what === "before";

/** One of a kind among the choices of a field. */
export function keyOf(against: Against | null): string {
  if (against?.what === "case") return `case ${against.id}`;
  if (against?.what === "before") return `before ${against.edit}`;
  return against?.what === "file" ? `file ${against.name}` : (against?.what ?? "");
}
