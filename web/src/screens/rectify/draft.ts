/** An edit that is open: drawn and dragged on the limb, not kept yet. */
import { type Vec3, xyz } from "../../geometry/vectors";
import type { Hit } from "../../viewer/surface";

export interface Draft {
  readonly kind: "load" | "relieve";
  readonly depth_mm: number;
  readonly falloff_mm: number;
  readonly flat_mm: number;
  /** A landmark's name, or a place in the mesh's frame. */
  readonly at: string | Vec3 | null;
  readonly within: readonly Vec3[];
  readonly anchor: Vec3;
  readonly normal: Vec3;
  readonly seed: number;
  readonly accept: readonly string[];
}

/** An edit as the server is asked to try or to keep it. */
export interface EditBody {
  readonly kind: string;
  readonly parameters: Record<string, unknown>;
  readonly accept: string[];
}

const FIRST_DEPTH_MM = 2;
/** Steps of the depth while its handle is dragged. */
const SNAP_MM = 0.5;

/** An edit that begins at a vertex. */
export function begun(part: Pick<Draft, "anchor" | "normal" | "seed" | "falloff_mm"> & Partial<Draft>): Draft {
  return { kind: "load", depth_mm: FIRST_DEPTH_MM, flat_mm: 0, at: null, within: [], accept: [], ...part };
}

/** Where a hand touched the limb, as an edit begins there. */
export const touched = (hit: Hit): Pick<Draft, "anchor" | "normal" | "seed"> => ({ anchor: xyz(hit.point), normal: xyz(hit.normal), seed: hit.vertex });

/** Which way it moves the surface along its normal: -1 carves in, 1 builds up. */
export const wayOf = ({ kind }: Draft): -1 | 1 => (kind === "load" ? -1 : 1);

/** The edit after its handle was dragged along the normal; a fine hand is not held to steps. */
export function pulled(draft: Draft, outward_mm: number, fine: boolean): Draft {
  const depth_mm = fine ? Math.abs(outward_mm) : Math.round(Math.abs(outward_mm) / SNAP_MM) * SNAP_MM;
  return { ...draft, kind: outward_mm < 0 ? "load" : "relieve", depth_mm: Number(depth_mm.toFixed(2)) };
}

export function bodyOf(draft: Draft): EditBody {
  const { kind, depth_mm, falloff_mm, flat_mm, at, within, anchor, accept } = draft;
  return { kind, parameters: { depth_mm, falloff_mm, ...(within.length ? inRegion(within) : atPlace(at ?? anchor, flat_mm)) }, accept: [...accept] };
}

const inRegion = (within: readonly Vec3[]) => ({ within: within.map((p) => [...p]), positions_in: "mesh" });

const atPlace = (at: string | Vec3, flat_mm: number) => (typeof at === "string" ? { at, flat_mm } : { at: [...at], flat_mm, positions_in: "mesh" });
