/**
 * The kinds of files, as the server tells them: which are written, who takes each, what may be asked of it, and which
 * are read. A new format needs no change here.
 */
import { signal } from "@preact/signals";

import type { Schemas } from "./api/client";
import { language, tOr } from "./texts";

export type ExportKind = Schemas["ExportKind"];

/** The everyday ones first; none until the server has answered. */
export const exportKinds = signal<readonly ExportKind[]>([]);

/** The endings of files that are read as shapes; none until the server has answered. */
export const shapeFiles = signal<readonly string[]>([]);

/** What a kind of file is called. */
export const fileName = (kind: string): string => tOr(`file.${kind}`, kind.toUpperCase());

/** Who takes it. */
export const usedFor = (kind: ExportKind): string => kind.used_for[language.value] ?? "";

/** Between what a number that may be asked of a kind has to lie, as the server checks it. */
export function limitsOf(kind: string, name: string): { readonly min?: number; readonly max?: number } {
  const field = fieldOf(kind, name);
  return { ...(field?.least != null && { min: field.least }), ...(field?.most != null && { max: field.most }) };
}

/** What a number is where nobody says it; undefined until the server has answered. */
export function usualOf(kind: string, name: string): number | undefined {
  const field = fieldOf(kind, name);
  return typeof field?.default === "number" ? field.default : (field?.usual ?? undefined);
}

/** One thing that may be asked of a kind. */
export const fieldOf = (kind: string, name: string) => exportKinds.value.find((one) => one.kind === kind)?.fields.find((one) => one.name === name);
