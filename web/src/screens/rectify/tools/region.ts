/** A region: drawn round in one go, or its corners pressed one after the other; the first one closes it. */
import { apart, middleOf, thinned } from "../../../geometry/region";
import { triple, xyz } from "../../../geometry/vectors";
import type { Hit } from "../../../viewer/surface";
import type { Tool } from "../../../viewer/viewer";
import type { Workspace } from "../workspace";
import { begun } from "../draft";
import type { Touch } from "../drawing";
import { CLOSE_PX } from "../trimline";
import { strokeTool } from "./stroke";

const LEAST_EDGE_MM = 4;
/** Of the way from the line to the middle, so that the depth is reached there. */
const MOST_EDGE = 0.8;

export function regionTool(now: () => Workspace): Tool {
  const close = (round: readonly Touch[]) => {
    const { size } = now().drawing;
    openRegion(
      now(),
      round.map((one) => one.hit),
      (reach_mm) => Math.max(LEAST_EDGE_MM, Math.min(size.value, reach_mm * MOST_EDGE)),
    );
  };
  const pressed = (touch: Touch) => {
    const { corners, line } = now().drawing;
    const [first, , third] = corners.current;
    if (third && Math.hypot(first.x - touch.x, first.y - touch.y) < CLOSE_PX) {
      close(corners.current);
    } else {
      corners.current = [...corners.current, touch];
      line.value = corners.current.map((one) => one.point);
    }
  };
  return strokeTool(now, close, pressed);
}

/** Open an edit within a line; `falloff_mm` is its soft edge, of the distance from the line to its middle. */
export function openRegion({ viewer, base, drawing, edit }: Workspace, round: readonly Hit[], falloff_mm: (reach_mm: number) => number): void {
  const within = apart(thinned(round).map((hit) => xyz(hit.point)));
  const surface = viewer.current?.surface;
  const middle = surface && base.data ? middleOf(within, base.data.positions) : null;
  if (!surface || !middle) {
    drawing.clear();
    return;
  }
  const { seed, anchor, reach_mm } = middle;
  edit.open(begun({ within, seed, anchor, normal: triple(surface.normals, seed), falloff_mm: falloff_mm(reach_mm) }));
}
