/** The trimline that a hand sets point by point on the limb, until it is cut. */
import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useMemo } from "preact/hooks";
import type { Vector3 } from "three";

import { type Pixel, nearestPixel } from "../../geometry/nearest";
import { glued, sentOf } from "../../geometry/trimline";
import { xyz } from "../../geometry/vectors";
import type { Viewer } from "../../viewer/viewer";
import type { Limb } from "../limb";
import type { EditBody } from "./draft";

/** Points round the limb that make a trimline. */
export const LEAST_TRIM = 4;
/** A press so near to a point means that point. */
export const CLOSE_PX = 14;

export interface Trimline {
  readonly points: Signal<readonly Vector3[]>;
  readonly closed: Signal<boolean>;
  /** The line as it is drawn. */
  readonly drawn: readonly Vector3[];
  /** The point under a pointer. */
  readonly knotAt: (event: PointerEvent) => number | null;
  /** Set one point more: on the line where that was pressed, else at its end. */
  readonly add: (point: Vector3, pressed: Pixel) => void;
  /** Take the last point away. */
  readonly back: () => void;
  readonly clear: () => void;
  readonly body: () => EditBody;
}

export function useTrimline(viewer: RefObject<Viewer | null>, limb: Limb | null): Trimline {
  const points = useSignal<readonly Vector3[]>([]);
  const closed = useSignal(false);

  const lineThrough = (through: readonly Vector3[], round: boolean): readonly Vector3[] => {
    const surface = viewer.current?.surface;
    return surface ? glued(through, round, surface) : through;
  };
  const onPage = (point: Vector3): Pixel | null => viewer.current?.onPage(point) ?? null;
  const drawn = useMemo(() => {
    const line = lineThrough(points.value, closed.value);
    return closed.value ? [...line, points.value[0]] : line;
  }, [points.value, closed.value, limb]);

  const knotAt = (event: PointerEvent) =>
    nearestPixel(points.value.map(onPage), [event.clientX, event.clientY], event.pointerType === "touch" ? 2 * CLOSE_PX : CLOSE_PX);

  /** The point after which the line goes through a place on the page. */
  const joinAt = (pressed: Pixel): number | null => {
    const line = points.value;
    const joins = line.slice(0, closed.value ? undefined : -1).map((from, i) => lineThrough([from, line[(i + 1) % line.length]], false));
    const found = nearestPixel(joins.flat().map(onPage), pressed, CLOSE_PX / 2);
    return found === null ? null : Math.floor(found / joins[0].length);
  };
  const add = (point: Vector3, pressed: Pixel) => {
    const after = joinAt(pressed);
    points.value = points.value.toSpliced(after === null ? points.value.length : after + 1, 0, point);
  };
  const back = () => {
    closed.value = false;
    points.value = points.value.slice(0, -1);
  };
  const clear = () => {
    points.value = [];
    closed.value = false;
  };
  const body = (): EditBody => {
    const surface = viewer.current?.surface;
    const sent = surface ? sentOf(points.value, surface) : points.value;
    return { kind: "trimline", parameters: { through: sent.map(xyz), keep: "distal", positions_in: "mesh" }, accept: [] };
  };
  return { points, closed, drawn, knotAt, add, back, clear, body };
}
