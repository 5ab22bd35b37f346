/** The shapes that were fetched, kept by case as long as their tag stays the same. */
import { bytesOf } from "../api/client";
import { decodeBlocks, surfaceOf } from "../api/blocks";
import { guessFrame } from "../geometry/guess";
import { type Rigid, type Vec3, vec3 } from "../geometry/vectors";
import type { Schemas } from "../api/client";
import type { SurfaceData } from "../viewer/surface";

export interface Fetched {
  readonly data: SurfaceData;
  readonly tag: string;
}

const kept = new Map<string, Fetched>();
const MOST = 4;

/** A surface of a case; fetched again only where the server has another than the one kept. */
export async function fetchSurface(caseId: string, of: "scan" | "rectified"): Promise<Fetched> {
  const key = `${caseId} ${of}`;
  const known = kept.get(key);
  const { bytes, tag, unchanged } = await bytesOf(
    `/cases/${encodeURIComponent(caseId)}/surface?of=${of}`,
    known && { headers: { "If-None-Match": known.tag } },
  );
  return known && unchanged ? known : keep(key, { data: surfaceOf(decodeBlocks(bytes)), tag });
}

function keep(key: string, fetched: Fetched): Fetched {
  kept.delete(key);
  kept.set(key, fetched);
  for (const old of [...kept.keys()].slice(0, Math.max(0, kept.size - MOST))) kept.delete(old);
  return fetched;
}

/** How far each vertex of the shape after the recipe lies from the scan, or from the shape before an edit. */
export async function fetchDifferences(caseId: string, beforeEdit: number | null): Promise<Float32Array> {
  const earlier = beforeEdit === null ? "" : `?edits=${beforeEdit - 1}`;
  const { bytes } = await bytesOf(`/cases/${encodeURIComponent(caseId)}/surface/differences${earlier}`);
  const block = decodeBlocks(bytes).blocks.get("signed_mm");
  return block instanceof Float32Array ? block : new Float32Array();
}

/** The motion into the frame shown: the limb's where it is aligned, else a guess. */
export function frameOf(limb: Schemas["LimbReply"], data: SurfaceData, front?: Vec3): Rigid {
  if (limb.rotation && limb.translation_mm) {
    const [x, y, z] = limb.rotation;
    return { rotation: [vec3(x), vec3(y), vec3(z)], translation: vec3(limb.translation_mm) };
  }
  return guessFrame(data.positions, data.indices, front);
}
