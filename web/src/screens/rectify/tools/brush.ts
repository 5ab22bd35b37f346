/** A stroke of the brush is the region round it, its size wide on each side; a press is a spot of that size. */
import { outlineOf } from "../../../geometry/region";
import { xyz } from "../../../geometry/vectors";
import type { Hit } from "../../../viewer/surface";
import type { Tool } from "../../../viewer/viewer";
import type { Workspace } from "../workspace";
import { begun, touched } from "../draft";
import type { Touch } from "../drawing";
import { openRegion } from "./region";
import { strokeTool } from "./stroke";

/** Points of an outline that lie on the limb; with fewer it is none. */
const LEAST_OUTLINE = 6;

export function brushTool(now: () => Workspace): Tool {
  const drawn = (stroke: readonly Touch[]) => {
    const { viewer, drawing } = now();
    const v = viewer.current;
    if (!v) return;
    const outline = outlineOf(stroke, drawing.size.value / v.mmPerPixel());
    const hits = outline.map(([x, y]) => v.hitAt(x, y)).filter((hit): hit is Hit => hit !== null);
    if (hits.length < LEAST_OUTLINE) return drawing.clear();
    openRegion(now(), hits, (reach_mm) => Math.max(1, Math.min(drawing.soft.value, reach_mm)));
  };
  const pressed = ({ hit }: Touch) => {
    const { drawing, edit } = now();
    const [size_mm, soft_mm] = [drawing.size.value, drawing.soft.value];
    edit.open(begun({ ...touched(hit), at: xyz(hit.point), flat_mm: Math.max(0, size_mm - soft_mm), falloff_mm: Math.min(soft_mm, size_mm) }));
  };
  return strokeTool(now, drawn, pressed);
}
