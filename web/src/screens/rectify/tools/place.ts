/** A press on the limb opens an edit there; near a landmark it is that one's. */
import { type Vec3, distance, vec3, xyz } from "../../../geometry/vectors";
import type { Hit } from "../../../viewer/surface";
import type { Tool } from "../../../viewer/viewer";
import type { Workspace } from "../workspace";
import { begun, touched } from "../draft";

/** A hand so near to a landmark means it. */
const NAMED_MM = 6;

export function placeTool(now: () => Workspace): Tool {
  let pressed: Hit | null = null;
  return {
    press(hit) {
      pressed = hit;
      return true;
    },
    release(hit) {
      const at = hit ?? pressed;
      if (!at) return;
      const { limb, drawing, edit } = now();
      const here = xyz(at.point);
      const named = limb?.reply.places.find((one) => distance(vec3(one.position_mm), here) < NAMED_MM);
      const anchor: Vec3 = named ? vec3(named.position_mm) : here;
      edit.open(begun({ ...touched(at), falloff_mm: drawing.size.value, at: named?.name ?? anchor, anchor }));
    },
    cancel() {
      pressed = null;
      now().drawing.line.value = [];
    },
  };
}
