import { Vector3 } from "three";
import { expect, test } from "vitest";

import { circleOn } from "../src/geometry/circle";

const CENTRE = new Vector3(5, -2, 30);

test.each([[new Vector3(0, 0, 1)], [new Vector3(0, 1, 0)], [new Vector3(0.6, 0, 0.8)]])(
  "a circle of its radius stands on the surface, a little off it",
  (normal) => {
    const points = circleOn(CENTRE, normal, 7);
    for (const p of points) {
      const away = p.clone().sub(CENTRE);
      expect(away.dot(normal)).toBeCloseTo(0.3, 9);
      expect(away.addScaledVector(normal, -0.3).length()).toBeCloseTo(7, 9);
    }
    const middle = points.reduce((sum, p) => sum.addScaledVector(p, 1 / points.length), new Vector3());
    expect(middle.distanceTo(CENTRE)).toBeCloseTo(0.3, 9); // all the way round
  },
);
