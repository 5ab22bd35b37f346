/** A circle that touches the surface: the brush as it is drawn over the limb. */
import { Vector3 } from "three";

const POINTS = 36;
/** Drawn so far off the surface that this does not hide it. */
const LIFTED_MM = 0.3;

/** Points round a place in the plane that touches the surface there; `normal` has length 1. */
export function circleOn(centre: Vector3, normal: Vector3, radius_mm: number): Vector3[] {
  const along = new Vector3(0, 0, 1).cross(normal);
  if (along.lengthSq() < 1e-6) along.set(1, 0, 0);
  along.normalize();
  const across = normal.clone().cross(along);
  return Array.from({ length: POINTS }, (_, i) => {
    const angle = (2 * Math.PI * i) / POINTS;
    return centre
      .clone()
      .addScaledVector(along, radius_mm * Math.cos(angle))
      .addScaledVector(across, radius_mm * Math.sin(angle))
      .addScaledVector(normal, LIFTED_MM);
  });
}
