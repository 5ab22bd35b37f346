/** What is drawn over the limb: the brush, the region, the line under the hand, the trimline, and the landmarks. */
import { Vector3 } from "three";

import { circleOn } from "../../geometry/circle";
import { vec3 } from "../../geometry/vectors";
import type { Handle } from "../../viewer/handles";
import type { Line, Mark } from "../../viewer/overlay";
import { term } from "../../words";
import type { Workspace } from "./workspace";
import { wayOf } from "./draft";

const LEAST_RING_MM = 0.5;

export function linesOf({ drawing, edit, trimline }: Workspace): Line[] {
  const within = edit.draft.value?.within ?? [];
  const line = drawing.line.value;
  const lines: Line[] = brushRings(drawing).map((points) => ({ points, closed: true, look: "draft" }));
  if (within.length) lines.push({ points: within.map((p) => new Vector3(...p)), closed: true, look: "region" });
  if (line.length) lines.push({ points: line, closed: false, look: "draft", knots: drawing.corners.current.length > 0 });
  if (trimline.points.value.length) {
    lines.push({ points: trimline.drawn, closed: false, look: "trimline" });
    lines.push({ points: trimline.points.value, closed: false, look: "knots", knots: true });
  }
  return lines;
}

/** The brush's rim and where its edge begins to fall off, round the place under the hand. */
function brushRings({ over, line, size, soft }: Workspace["drawing"]): Vector3[][] {
  const hit = over.value;
  if (!hit || line.value.length) return [];
  return [size.value, size.value - soft.value].filter((radius_mm) => radius_mm > LEAST_RING_MM).map((radius_mm) => circleOn(hit.point, hit.normal, radius_mm));
}

export function marksOf({ limb, edit }: Workspace): Mark[] {
  const chosen = edit.draft.value?.at;
  return (limb?.reply.places ?? []).map((one) => ({
    name: one.name,
    label: term(one.name),
    point: new Vector3(...vec3(one.position_mm)),
    state: chosen === one.name ? "chosen" : "set",
  }));
}

/** The handle by which the depth of the open edit is dragged. */
export function handleOf({ edit }: Workspace): Handle | null {
  const draft = edit.draft.value;
  return draft && { point: new Vector3(...draft.anchor), normal: new Vector3(...draft.normal), depth_mm: wayOf(draft) * draft.depth_mm };
}
