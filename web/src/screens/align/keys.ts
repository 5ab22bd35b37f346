/** Keys: Enter sets the place in the middle of the canvas, Escape lets go, arrows move a place. */
import { useEffect } from "preact/hooks";
import { Vector3 } from "three";

import { vec3 } from "../../geometry/vectors";
import type { Placing } from "./placing";
import type { Subject } from "./subject";

const STEP_MM = 0.5;
const FINE_MM = 0.1;
/** To the right and up. */
const WAYS: Readonly<Record<string, readonly [number, number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export function useKeys({ viewer }: Subject, { armed, held, put, after }: Placing): void {
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      const v = viewer.current;
      if (event.target instanceof HTMLInputElement) return;
      if (event.key === "Escape") {
        armed.value = null;
        held.value = null;
      }
      const name = armed.value;
      if (event.key !== "Enter" || !name || !v || document.activeElement !== v.canvas) return;
      const box = v.canvas.getBoundingClientRect();
      const hit = v.hitAt(box.left + box.width / 2, box.top + box.height / 2);
      if (hit) {
        put(name, hit.point);
        armed.value = after(name);
      }
      event.preventDefault();
    };
    addEventListener("keydown", key);
    return () => removeEventListener("keydown", key);
  });
}

/** Arrows on a row move its place over the surface. */
export function nudge({ viewer }: Subject, { places, put }: Placing, name: string, event: KeyboardEvent): void {
  const way = WAYS[event.key];
  const one = places.find((p) => p.name === name);
  const v = viewer.current;
  if (!way || !one || !v?.surface) return;
  event.preventDefault();
  const step_mm = event.shiftKey ? FINE_MM : STEP_MM;
  const { right, up } = v.axes();
  const shown = v.surface.toShown(new Vector3(...vec3(one.position_mm)));
  shown.addScaledVector(right, way[0] * step_mm).addScaledVector(up, way[1] * step_mm);
  put(name, v.surface.toMesh(shown));
}
