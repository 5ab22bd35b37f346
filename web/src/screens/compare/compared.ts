/** How the shape differs from another one, as the server answers it. */
import { decodeBlocks } from "../../api/blocks";
import { bytesOf } from "../../api/client";
import { widthFor } from "../../geometry/scales";
import type { SurfaceData } from "../../viewer/surface";
import type { Finding } from "../../words";
import { type Against, asked } from "./against";

/** Which shape of the case is compared. */
export type Which = "scan" | "rectified";
export type Way = "auto" | "icp" | "landmarks" | "volume" | "as-is";
export const WAYS: readonly Way[] = ["auto", "icp", "landmarks", "volume", "as-is"];

/** A figure of both shapes, as the server tells it. */
interface Change {
  readonly first: number;
  readonly second: number;
  readonly difference: number;
  readonly share: number | null;
  readonly sigma: number | null;
}

export interface Figures {
  readonly grade: string;
  readonly verdict: Finding;
  readonly alignment: { readonly way: Way; readonly rms_mm: number | null; readonly far_limit_mm: number; readonly slide_within_mm: number | null };
  readonly radial: {
    readonly mean_radial_error_mm: number;
    readonly mean_limit_mm: number;
    readonly interquartile_range_mm: number;
    readonly range_limit_mm: number;
  } | null;
  readonly surface: { readonly on_second: { readonly p95_mm: number; readonly largest_mm: number; readonly far_mm2: number; readonly compared_share: number } };
  readonly volume: { readonly ml: Change | null; readonly sock_plies: number | null; readonly to_mm: number | null; readonly within_ml: number | null };
  readonly levels: readonly { readonly height_mm: number; readonly tape_mm?: Change | null; readonly reason: Finding | null }[];
  readonly anatomical_frame: boolean;
  readonly notes: readonly Finding[];
}

export interface Compared {
  readonly surface: SurfaceData;
  readonly values: Float32Array;
  readonly figures: Figures;
}

/** The server lays the shapes on each other, and tells how they differ. */
export async function compared(id: string, of: Which, against: Against, align: Way, spacing_mm: number): Promise<Compared> {
  const { bytes: answer } = await bytesOf(`/cases/${encodeURIComponent(id)}/compare/differences`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ of, align, spacing_mm, ...asked(against) }),
  });
  const { header, blocks } = decodeBlocks(answer);
  const [positions, indices, values] = [blocks.get("positions"), blocks.get("indices"), blocks.get("signed_mm")];
  const surface: SurfaceData = {
    positions: positions instanceof Float32Array ? positions : new Float32Array(),
    indices: indices instanceof Uint32Array ? indices : new Uint32Array(),
    sigma: null,
    colours: null,
    filled: null,
  };
  return { surface, values: values instanceof Float32Array ? values : new Float32Array(), figures: header.figures as Figures };
}

/** The factor of the bands by what all but a hundredth of the surface keeps: one stray corner is no scale. */
export function widest(values: Float32Array): number {
  const sizes = values
    .filter((v) => Number.isFinite(v))
    .map(Math.abs)
    .sort();
  return widthFor(sizes.length ? sizes[Math.floor(0.99 * (sizes.length - 1))] : 0);
}
