/** A hand that draws on the limb: the way it went, or the one press where it hardly moved. */
import type { Tool } from "../../../viewer/viewer";
import type { Workspace } from "../workspace";
import type { Touch } from "../drawing";

/** The hand's way is noted so often, px. */
const STEP_PX = 5;
/** Fewer are a press. */
const LEAST_TOUCHES = 8;

export function strokeTool(now: () => Workspace, drawn: (touches: readonly Touch[]) => void, pressed: (touch: Touch) => void): Tool {
  let way: Touch[] = [];
  return {
    press(hit, event) {
      way = [{ point: hit.point, x: event.clientX, y: event.clientY, hit }];
      return true;
    },
    slide(hit, event) {
      const last = way[way.length - 1];
      if (!hit || Math.hypot(event.clientX - last.x, event.clientY - last.y) < STEP_PX) return;
      way.push({ point: hit.point, x: event.clientX, y: event.clientY, hit });
      now().drawing.line.value = way.map((one) => one.point);
    },
    release() {
      if (way.length < LEAST_TOUCHES) {
        if (way[0]) pressed(way[0]);
      } else drawn(way);
    },
    cancel() {
      way = [];
      const { line, corners } = now().drawing;
      line.value = corners.current.map((one) => one.point);
    },
  };
}
