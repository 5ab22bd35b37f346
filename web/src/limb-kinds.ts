/**
 * The kinds of limb, as the server tells them: a kind's own file has its names in every language. A new kind needs no
 * change here.
 */
import { signal } from "@preact/signals";

import type { Schemas } from "./api/client";
import { language, t } from "./texts";

export type LimbKind = Schemas["LimbKind"];

/** None until the server has answered. */
export const limbKinds = signal<readonly LimbKind[]>([]);

/** What people call a kind; its name until the server has answered, and words of their own where nobody said it. */
export const kindName = (kind: LimbKind["kind"] | null | undefined): string =>
  kind ? (limbKinds.value.find((one) => one.kind === kind)?.words[language.value] ?? kind) : t("kind.none");

/** Whether it is a left or a right one; where nobody said the kind, it may be. */
export const sided = (kind: LimbKind["kind"] | null | undefined): boolean => limbKinds.value.find((one) => one.kind === kind)?.sided ?? true;
