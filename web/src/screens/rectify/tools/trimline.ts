/** Points of a trimline are set one after the other, dragged, and put into the line; the first one closes it. */
import type { Tool } from "../../../viewer/viewer";
import type { Workspace } from "../workspace";
import type { Touch } from "../drawing";
import { LEAST_TRIM } from "../trimline";

export function trimlineTool(now: () => Workspace): Tool {
  let pressed: Touch | null = null;
  /** Which point is dragged. */
  let dragged: number | null = null;
  return {
    press(hit, event) {
      pressed = { point: hit.point, x: event.clientX, y: event.clientY, hit };
      dragged = now().trimline.knotAt(event);
      return true;
    },
    slide(hit) {
      const { points } = now().trimline;
      if (hit && dragged !== null) points.value = points.value.map((p, i) => (i === dragged ? hit.point : p));
    },
    release() {
      if (!pressed) return;
      const { points, closed, add } = now().trimline;
      if (dragged === 0 && points.value.length >= LEAST_TRIM) closed.value = true;
      else if (dragged === null) add(pressed.point, [pressed.x, pressed.y]);
      dragged = null;
    },
    cancel() {
      pressed = null;
      dragged = null;
      now().drawing.line.value = [];
    },
  };
}
