/**
 * The kinds of edits, as the server tells them: an edit's own file has its names and its help in every
 * language, and what its parameters may be. A new edit needs no change here.
 */
import { signal } from "@preact/signals";

import type { Schemas } from "./api/client";
import { language } from "./texts";

export type EditKind = Schemas["EditKind"];
export type Parameter = Schemas["FieldReply"];

/** None until the server has answered. */
export const editKinds = signal<readonly EditKind[]>([]);

/** What an edit is called, and the name that recipes use until that is known. */
export const editName = (kind: string) => wordsOf(kind)?.name ?? kind;

/** What it does. */
export const purposeOf = (kind: string) => wordsOf(kind)?.does ?? "";

/** The edits to which it belongs. */
export const groupOf = (kind: string) => wordsOf(kind)?.group ?? "";

/** What a parameter is called. */
export const labelOf = (kind: string, name: string) => wordsOf(kind)?.labels[name] ?? name;

/** What it means. */
export const helpOf = (kind: string, name: string) => wordsOf(kind)?.help[name] ?? "";

/** What a word to choose is called; undefined where it is no such word. */
export const choiceOf = (kind: string, choice: string): string | undefined => wordsOf(kind)?.choices[choice];

const wordsOf = (kind: string): Schemas["EditWords"] | undefined => editKinds.value.find((one) => one.kind === kind)?.words[language.value];
