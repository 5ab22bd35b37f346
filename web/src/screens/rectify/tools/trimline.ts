/** Points of a trimline are set one after the other, dragged, and put into the line; the first one closes it. */
import type { Tool } from "../../../viewer/viewer";
import type { Workspace } from "../workspace";
import type { Touch } from "../drawing";
import { LEAST_TRIM } from "../trimline";

/** A hand that moved less pressed a point; it did not drag it. */
const STILL_PX = 4;

export function trimlineTool(now: () => Workspace): Tool {
  let pressed: Touch | null = null;
  /** Which point was taken, and whether it was dragged. */
  let taken: number | null = null;
  let dragged = false;
  return {
    press(hit, event) {
      pressed = { point: hit.point, x: event.clientX, y: event.clientY, hit };
      taken = now().trimline.knotAt(event);
      dragged = false;
      return true;
    },
    slide(hit, event) {
      if (!hit || !pressed || taken === null) return;
      dragged ||= Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) >= STILL_PX;
      const { points } = now().trimline;
      if (dragged) points.value = points.value.map((p, i) => (i === taken ? hit.point : p));
    },
    release() {
      if (!pressed) return;
      const { points, closed, add } = now().trimline;
      if (taken === null) add(pressed.point, [pressed.x, pressed.y]);
      else if (taken === 0 && !dragged && points.value.length >= LEAST_TRIM) closed.value = true;
      taken = null;
    },
    cancel() {
      pressed = null;
      taken = null;
      now().drawing.line.value = [];
    },
  };
}
