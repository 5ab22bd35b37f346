/** What the edit that is open does to the limb, in figures. */
import { useMemo } from "preact/hooks";

import { cut, heightsOf } from "../../geometry/section";
import type { Workspace } from "./workspace";
import { wayOf } from "./draft";
import { changed } from "./ledger";
import { touching } from "./skin";

export interface Girth {
  readonly height_mm: number;
  readonly now_mm: number;
  readonly change_mm: number;
}

/**
 * The girth at the level of the skin that touches the limb, of the server's answer; while the hand drags, of
 * what this page moved.
 */
export function useGirth({ limb, base, level, edit, ledger, trial, viewer }: Workspace): Girth | null {
  const { data } = base;
  const height_mm = level.value;
  const heights = useMemo(() => (limb && data ? heightsOf(data.positions, limb.frame) : null), [limb, data]);
  const edits = ledger.book?.recipe.edits ?? [];
  const skin = touching(edits);
  const before_mm = useMemo(
    () => (limb && data && heights && height_mm !== null ? cut(data.positions, data.indices, heights, height_mm, limb.frame, skin).tape_mm : NaN),
    [limb, data, heights, height_mm, skin],
  );
  return useMemo(() => {
    if (!limb || height_mm === null || !data) return null;
    const drawn = viewer.current?.surface;
    const here = edit.draft.value && drawn?.data === data ? drawn.positions : data.positions;
    const { positions, indices } = trial.tried.value?.surface ?? { positions: here, indices: data.indices };
    const tried = trial.tried.value ? touching([...edits, trial.tried.value.body]) : skin;
    const now_mm =
      positions === data.positions && tried === skin
        ? before_mm
        : cut(positions, indices, heightsOf(positions, limb.frame), height_mm, limb.frame, tried).tape_mm;
    return Number.isFinite(now_mm) ? { height_mm, now_mm, change_mm: now_mm - before_mm } : null;
  }, [limb, height_mm, trial.tried.value, data, before_mm, skin, edit.draft.value, edit.previewed.value]);
}

/** By how much the edit changes the volume, mL: of the server's answer, until then of this page's preview. */
export function volumeOf({ edit, trial }: Workspace): number | null {
  const line = trial.tried.value?.line;
  if (line) return changed(line.volume);
  const draft = edit.draft.value;
  return draft && edit.area_mm2 !== null ? (wayOf(draft) * edit.area_mm2 * draft.depth_mm) / 1000 : null;
}

/** The class of a change: less, more, or nothing that a decimal shows. */
export const toneOf = (change: number): "neg" | "pos" | "" => (change < -0.05 ? "neg" : change > 0.05 ? "pos" : "");
