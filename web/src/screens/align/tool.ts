/** A press on the limb sets a place on release, so a hand may slide to it; a place that is set can be dragged. */
import { useMemo, useRef } from "preact/hooks";
import { Vector3 } from "three";

import { nearestPixel } from "../../geometry/nearest";
import { distance, vec3, xyz } from "../../geometry/vectors";
import { t } from "../../texts";
import type { Tool } from "../../viewer/viewer";
import type { Placing } from "./placing";
import type { Subject } from "./subject";

const GRAB_PX = 14;
const GRAB_TOUCH_PX = 30;
/** How far the surface may lie before a place that still is seen. */
const SEEN_MM = 2;
/** A hand this near to a guess lands on it. */
const CATCH_MM = 4;

export function useTool({ limb, viewer, saved }: Subject, placing: Placing): Tool {
  // It is made once a limb; what it works on is of the latest render.
  const latest = useRef(placing);
  latest.current = placing;
  return useMemo(() => {
    const { armed, chosen, held } = placing;
    let moving: string | null = null;
    const under = (event: PointerEvent): string | null => {
      const v = viewer.current;
      if (!v?.surface) return null;
      const { places } = latest.current;
      const seen = places.map((one) => v.onPage(new Vector3(...vec3(one.position_mm)), SEEN_MM));
      const found = nearestPixel(seen, [event.clientX, event.clientY], event.pointerType === "touch" ? GRAB_TOUCH_PX : GRAB_PX);
      return found === null ? null : places[found].name;
    };
    /** A guess under the hand: a place that is released there is that one. */
    const caught = (point: Vector3): Vector3 => {
      const one = latest.current.offered.find((guess) => distance(guess.at, xyz(point)) < CATCH_MM);
      return one ? new Vector3(...one.at) : point;
    };
    return {
      press(hit, event) {
        moving = under(event) ?? armed.value;
        if (!moving) return false;
        chosen.value = moving;
        held.value = { name: moving, point: caught(hit.point) };
        return true;
      },
      slide(hit) {
        if (!moving) return;
        if (hit) held.value = { name: moving, point: caught(hit.point) };
        saved.value = hit ? "" : t("align.silhouette");
      },
      release() {
        const now = held.value;
        const name = moving;
        moving = null;
        if (!now || !name) return;
        latest.current.put(name, now.point);
        if (armed.value === name) armed.value = latest.current.after(name);
      },
      cancel() {
        moving = null;
        held.value = null;
      },
    };
  }, [limb?.reply.sha256]);
}
