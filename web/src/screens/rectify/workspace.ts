/** Everything that the parts of this screen share: the limb and its recipe, the tool, and the edit that is open. */
import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useMemo, useRef } from "preact/hooks";

import { newOffer } from "../../state/acts";
import type { Query } from "../../state/requests";
import type { Mode } from "../../viewer/surface";
import type { Viewer } from "../../viewer/viewer";
import { type Limb, useLimb } from "../limb";
import type { OpenCase } from "../open-case";
import { type Base, useBase } from "./base";
import { bodyOf } from "./draft";
import { type Drawing, useDrawing } from "./drawing";
import { type Ledger, useLedger } from "./ledger";
import { type Keeping, type OpenEdit, useOpenEdit } from "./open-edit";
import { type RecipeChanges, useRecipeChanges } from "./recipe-changes";
import { type Trial, useTrial } from "./trial";
import { type Trimline, useTrimline } from "./trimline";

export interface Workspace {
  readonly openCase: OpenCase;
  readonly viewer: RefObject<Viewer | null>;
  readonly mode: Signal<Mode>;
  /** Where the girth is read, mm. */
  readonly level: Signal<number | null>;
  readonly limb: Limb | null;
  /** Why there is no limb. */
  readonly limbRefused: Query<unknown>["refused"];
  readonly ledger: Ledger;
  readonly base: Base;
  readonly drawing: Drawing;
  readonly trial: Trial;
  readonly trimline: Trimline;
  readonly edit: OpenEdit;
  readonly keeping: Keeping;
  readonly recipe: RecipeChanges;
}

export function useWorkspace(openCase: OpenCase): Workspace {
  const { limb, asked } = useLimb(openCase, "rectified");
  const viewer = useRef<Viewer | null>(null);
  const mode = useSignal<Mode>("difference");
  const level = useSignal<number | null>(null);
  const drawing = useDrawing();
  const ledger = useLedger(openCase);
  const base = useBase(openCase, limb, ledger.book);
  const trial = useTrial(openCase.id, base, viewer);
  const trimline = useTrimline(viewer, limb);
  const keeping: Keeping = { now: useSignal(false), offer: useMemo(newOffer, []) };
  const edit = useOpenEdit({ viewer, level, base, trial, drawing, trimline, keeping });
  const recipe = useRecipeChanges(openCase, { ledger, base, trial, keeping, drop: edit.drop, again: asked.again });
  return { openCase, viewer, mode, level, limb, limbRefused: asked.refused, ledger, base, drawing, trial, trimline, edit, keeping, recipe };
}

/** What is drawn and not kept: leaving the page would lose it. */
export const unkept = ({ edit, trimline }: Workspace): "edit" | "trimline" | null =>
  edit.draft.value ? "edit" : trimline.points.value.length > 0 ? "trimline" : null;

/** Keep the edit that is drawn. */
export function keepDrawn({ edit, recipe }: Workspace): void {
  const now = edit.draft.value;
  if (now) void recipe.add(bodyOf(now));
}
