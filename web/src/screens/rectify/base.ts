/** The shape after the recipe, on which an edit is tried, and how far it lies from what its colours are held against. */
import { useSignal } from "@preact/signals";
import { useMemo, useRef } from "preact/hooks";

import type { Schemas } from "../../api/client";
import { useQuery } from "../../state/requests";
import { fetchDifferences } from "../../state/shapes";
import type { SurfaceData } from "../../viewer/surface";
import type { Limb } from "../limb";
import type { OpenCase } from "../open-case";

export interface Base {
  readonly limb: Limb | null;
  readonly data: SurfaceData | null;
  readonly differences_mm: Float32Array;
  /** The edit before which the shape is the one that colours are against; null: the scan. */
  readonly before: number | null;
  readonly against: (edit: number | null) => void;
  /** Show so far what the trial showed of an edit that is kept: the same shape, until the server's own map is here. */
  readonly carry: (tried_mm: Float32Array | null) => void;
}

export function useBase(openCase: OpenCase, limb: Limb | null, book: Schemas["Ledgered"] | null): Base {
  const chosen = useSignal<number | null>(null);
  const carried = useRef<Float32Array | null>(null);
  // An edit that was taken out has no state before it: then the colours are against the scan again.
  const before = chosen.value !== null && chosen.value <= (book?.recipe.edits.length ?? 0) ? chosen.value : null;
  const asks = `${limb?.fetched.tag} ${before}`;
  const asked = useQuery(async () => ({ values: await fetchDifferences(openCase.id, before), of: asks }), [openCase.id, asks]);
  const data = limb?.fetched.data ?? null;
  const found = asked.value.value;
  const differences_mm = useMemo(() => {
    const count = data ? data.positions.length / 3 : 0;
    const own = found?.of === asks ? found.values : null;
    return [own, carried.current, found?.values].find((values) => values?.length === count) ?? new Float32Array(count);
  }, [found, data, asks]);
  return { limb, data, differences_mm, before, against: (edit) => (chosen.value = edit), carry: (tried_mm) => (carried.current = tried_mm) };
}
