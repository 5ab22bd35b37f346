/**
 * A trimline: a line round the limb through points that a hand set.
 *
 * In      points on the surface, mm in the mesh's frame.
 * Out     the line that lies on the surface between them, as it is drawn and as it is sent.
 * Method  between two points the angle round the long axis, the radius and the height go evenly; each
 *         such point is brought to the nearest place of the surface.
 */
import { Vector3 } from "three";

/** Pieces into which the line is parted between two points. */
export const PIECES = 10;
/** The server draws a smooth line through the points, which may leave the limb between far ones. */
const APART_MM = 25;

/** A surface with its two frames: the mesh's, and the one shown, whose z is the long axis. */
export interface Round {
  toShown(inMesh: Vector3): Vector3;
  toMesh(inShown: Vector3): Vector3;
  /** The place of the surface nearest to a point, both in the mesh's frame. */
  nearest(inMesh: Vector3): Vector3;
}

/** The line on the surface through some points: `PIECES` points for each join, and the last one where it is open. */
export function glued(points: readonly Vector3[], closed: boolean, surface: Round): Vector3[] {
  if (points.length < 2) return [...points];
  const shown = points.map((p) => surface.toShown(p));
  const made: Vector3[] = [];
  for (let i = 0; i < (closed ? points.length : points.length - 1); i++) {
    const [a, b] = [shown[i], shown[(i + 1) % points.length]];
    const [from, to] = [Math.atan2(a.y, a.x), Math.atan2(b.y, b.x)];
    const turn = Math.atan2(Math.sin(to - from), Math.cos(to - from));
    const [ra, rb] = [Math.hypot(a.x, a.y), Math.hypot(b.x, b.y)];
    for (let k = 0; k < PIECES; k++) {
      const s = k / PIECES;
      const angle = from + s * turn;
      const r = ra + s * (rb - ra);
      const near = new Vector3(r * Math.cos(angle), r * Math.sin(angle), a.z + s * (b.z - a.z));
      made.push(k === 0 ? points[i] : surface.nearest(surface.toMesh(near)));
    }
  }
  if (!closed) made.push(points[points.length - 1]);
  return made;
}

/** The points of a closed trimline that are sent: those that were set, and between far ones others of the line that is drawn. */
export function sentOf(points: readonly Vector3[], surface: Round): Vector3[] {
  const line = glued(points, true, surface);
  return points.flatMap((_, i) => {
    const piece = line.slice(PIECES * i, PIECES * (i + 1));
    const end = line[(PIECES * (i + 1)) % line.length];
    const length_mm = piece.reduce((sum, p, k) => sum + p.distanceTo(piece[k + 1] ?? end), 0);
    const parts = Math.min(PIECES, Math.max(1, Math.ceil(length_mm / APART_MM)));
    return Array.from({ length: parts }, (_, k) => piece[Math.round((k * PIECES) / parts)]);
  });
}
