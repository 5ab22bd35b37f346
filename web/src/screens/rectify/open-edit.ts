/**
 * The edit that is open on the limb, from the first stroke until it is kept or dropped.
 *
 * While a hand drags, this page moves the surface itself; after release the server tries the edit.
 * While an edit is being kept it holds still.
 */
import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";

import { type Neighbours, type Shares, areaOf, displaced, neighboursOf, sharesAtPlace, sharesInRegion } from "../../geometry/edit-preview";
import { nearestVertex } from "../../geometry/nearest";
import { widthOf } from "../../geometry/scales";
import { apply } from "../../geometry/vectors";
import type { Offer } from "../../state/acts";
import type { SurfaceData } from "../../viewer/surface";
import type { Viewer } from "../../viewer/viewer";
import type { Base } from "./base";
import { type Draft, type EditBody, bodyOf, pulled, wayOf } from "./draft";
import type { Drawing } from "./drawing";
import type { Trial } from "./trial";
import type { Trimline } from "./trimline";

/** A deeper edit is asked for once more. */
const ASK_BEYOND_MM = 8;

export interface OpenEdit {
  readonly draft: Signal<Draft | null>;
  /** Of the surface that it moves, each part by its share of the depth, mm2. */
  readonly area_mm2: number | null;
  /** Whether it is so deep that a hand may have slipped. */
  readonly asksDepth: Signal<boolean>;
  /** Counts what this page moved itself, so that the girth follows the hand. */
  readonly previewed: Signal<number>;
  readonly open: (next: Draft) => void;
  readonly change: (part: Partial<Draft>) => void;
  /** Drag its handle to a depth, outward positive. */
  readonly pull: (outward_mm: number, done: boolean, fine: boolean) => void;
  /** Try an edit that is not drawn on the limb. */
  readonly tryNew: (body: EditBody) => void;
  readonly drop: () => void;
}

interface Context {
  readonly viewer: RefObject<Viewer | null>;
  readonly level: Signal<number | null>;
  readonly base: Base;
  readonly trial: Trial;
  readonly drawing: Drawing;
  readonly trimline: Trimline;
  readonly keeping: Keeping;
}

/** Whether the edit that is open is being kept. */
export interface Keeping {
  readonly now: Signal<boolean>;
  /** Of that edit as it is now: kept twice it is in the recipe once. */
  readonly offer: Offer;
}

export function useOpenEdit({ viewer, level, base, trial, drawing, trimline, keeping }: Context): OpenEdit {
  const draft = useSignal<Draft | null>(null);
  const asksDepth = useSignal(false);
  const previewed = useSignal(0);
  /** How deep it was when the hand took the handle. */
  const pulledFrom = useRef<number | null>(null);
  const { data, differences_mm } = base;
  const shares = useShares(draft.value, data);
  const area_mm2 = useMemo(() => (data && shares ? areaOf(data.positions, data.indices, shares) : null), [data, shares]);

  /** The surface that is drawn, where it is the base and no answer of the server. */
  const drawnBase = () => {
    const surface = viewer.current?.surface;
    return surface && data && surface.data === data ? surface : null;
  };
  /** Those of the base before anything was moved. */
  const normals = useRef<{ readonly of: SurfaceData; readonly values: Float32Array } | null>(null);
  const preview = (next: Draft) => {
    const surface = drawnBase();
    if (!surface || !shares) return;
    const own = normals.current?.of === surface.data ? normals.current : (normals.current = { of: surface.data, values: surface.normals.slice() });
    const ground = { positions: surface.data.positions, normals: own.values, differences_mm };
    const moved = displaced(ground, shares, wayOf(next) * next.depth_mm);
    surface.move(shares.vertices, moved.positions);
    previewed.value += 1;
    surface.showDifference(moved.differences_mm, widthOf(moved.differences_mm));
    viewer.current?.draw();
  };

  const open = (next: Draft) => {
    if (keeping.now.value) return;
    draft.value = next;
    asksDepth.value = false;
    trial.tried.value = null;
    drawing.clear();
    level.value = base.limb ? Math.round(apply(base.limb.frame, next.anchor)[2]) : null;
    void trial.ask(bodyOf(next));
  };
  const change = (part: Partial<Draft>) => {
    if (!draft.value || keeping.now.value) return;
    draft.value = { ...draft.value, ...part };
    if (draft.value.depth_mm <= ASK_BEYOND_MM) asksDepth.value = false;
    void trial.ask(bodyOf(draft.value));
  };
  const tryNew = (body: EditBody) => {
    if (!keeping.now.value) void trial.ask(body);
  };
  const drop = () => {
    if (keeping.now.value) return;
    trial.passOver();
    trial.refused.value = null;
    trial.waits.value = false;
    keeping.offer.over();
    draft.value = null;
    asksDepth.value = false;
    drawing.clear();
    trimline.clear();
    const surface = drawnBase();
    if (!surface) return;
    surface.restore();
    surface.showDifference(differences_mm, widthOf(differences_mm));
    viewer.current?.draw();
  };
  const pull = (outward_mm: number, done: boolean, fine: boolean) => {
    const now = draft.value;
    if (!now || !viewer.current || keeping.now.value) return;
    const next = pulled(now, outward_mm, fine);
    const begun_mm = (pulledFrom.current ??= now.depth_mm);
    if (done) pulledFrom.current = null;
    if (trial.tried.value) trial.passOver();
    draft.value = next;
    preview(next);
    if (!done) return;
    if (next.depth_mm === 0) return drop();
    if (next.depth_mm <= ASK_BEYOND_MM) asksDepth.value = false;
    else if (begun_mm <= ASK_BEYOND_MM) asksDepth.value = true;
    void trial.ask(bodyOf(next));
  };

  // A change elsewhere made another shape under the edit that is open: it is tried again, on that one.
  useEffect(() => {
    const now = draft.value;
    if (!now || !data || keeping.now.value) return;
    trial.tried.value = null;
    draft.value = { ...now, seed: nearestVertex(data.positions, now.anchor) };
    void trial.ask(bodyOf(draft.value));
  }, [data]);
  // Until the server has answered, and after its answer was taken away, the base is moved here.
  useEffect(() => {
    if (draft.value && !trial.tried.value) preview(draft.value);
  }, [trial.tried.value, shares]);

  return { draft, area_mm2, asksDepth, previewed, open, change, pull, tryNew, drop };
}

/** Which vertices the edit moves, each by which share of its depth. */
function useShares(draft: Draft | null, data: SurfaceData | null): Shares | null {
  const near = useMemo<Neighbours | null>(() => (data ? neighboursOf(data.positions.length / 3, data.indices) : null), [data]);
  return useMemo(() => {
    if (!draft || !data || !near) return null;
    const { within, seed, anchor, flat_mm, falloff_mm } = draft;
    return within.length
      ? sharesInRegion(data.positions, near, within, seed, falloff_mm)
      : sharesAtPlace(data.positions, near, seed, anchor, flat_mm, falloff_mm);
  }, [draft?.within, draft?.anchor, draft?.falloff_mm, draft?.flat_mm, draft?.seed, data, near]);
}
