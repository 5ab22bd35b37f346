/**
 * A guess of where the limb's axes lie, before anybody has aligned it.
 *
 * The long axis is the axis of least inertia of the vertices; its open end is taken as proximal.
 * The front is only a guess: towards `front`, a direction in the mesh's frame, where one is known.
 */
import { type Rigid, type Vec3, add, cross, dot, scale, sub, unit } from "./vectors";

export function guessFrame(positions: Float32Array, indices: Uint32Array, front: Vec3 = [0, -1, 0]): Rigid {
  const centre = centreOf(positions);
  const axis = longAxis(positions, centre);
  const rim = rimOf(positions, indices);
  const along = (p: Vec3) => dot(sub(p, centre), axis);
  const up = rim && Math.abs(along(rim)) > 1 ? along(rim) : axis[2] || 1;
  const z = up < 0 ? scale(axis, -1) : axis;
  const sideways = sub(front, scale(z, dot(front, z)));
  const y = Math.hypot(...sideways) > 0.1 ? unit(sideways) : unit(cross(z, Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
  const x = cross(y, z);
  let lowest = Infinity;
  for (let i = 0; i < positions.length; i += 3) lowest = Math.min(lowest, z[0] * positions[i] + z[1] * positions[i + 1] + z[2] * positions[i + 2]);
  const origin = add(centre, scale(z, lowest - dot(centre, z)));
  return { rotation: [x, y, z], translation: [-dot(x, origin), -dot(y, origin), -dot(z, origin)] };
}

function centreOf(positions: Float32Array): Vec3 {
  let [x, y, z] = [0, 0, 0];
  const n = positions.length / 3;
  for (let i = 0; i < positions.length; i += 3) {
    x += positions[i];
    y += positions[i + 1];
    z += positions[i + 2];
  }
  return [x / n, y / n, z / n];
}

/** The eigenvector of the largest eigenvalue of the vertices' scatter, by repeated multiplication. */
function longAxis(positions: Float32Array, c: Vec3): Vec3 {
  const m = [0, 0, 0, 0, 0, 0];
  for (let i = 0; i < positions.length; i += 3) {
    const x = positions[i] - c[0];
    const y = positions[i + 1] - c[1];
    const z = positions[i + 2] - c[2];
    m[0] += x * x;
    m[1] += x * y;
    m[2] += x * z;
    m[3] += y * y;
    m[4] += y * z;
    m[5] += z * z;
  }
  let v: Vec3 = unit([0.2, 0.3, 0.93]);
  for (let k = 0; k < 200; k++)
    v = unit([m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[1] * v[0] + m[3] * v[1] + m[4] * v[2], m[2] * v[0] + m[4] * v[1] + m[5] * v[2]]);
  return v;
}

/** The middle of the longest open rim, or null where the surface is closed. */
function rimOf(positions: Float32Array, indices: Uint32Array): Vec3 | null {
  const n = positions.length / 3;
  const edges = new Set<number>();
  for (let f = 0; f < indices.length; f += 3)
    for (let k = 0; k < 3; k++) {
      const a = indices[f + k];
      const b = indices[f + ((k + 1) % 3)];
      const back = b * n + a;
      if (!edges.delete(back)) edges.add(a * n + b);
    }
  if (!edges.size) return null;
  let sum: Vec3 = [0, 0, 0];
  let weight = 0;
  for (const key of edges) {
    const a = Math.floor(key / n);
    const b = key % n;
    const pa: Vec3 = [positions[3 * a], positions[3 * a + 1], positions[3 * a + 2]];
    const pb: Vec3 = [positions[3 * b], positions[3 * b + 1], positions[3 * b + 2]];
    const size = Math.hypot(...sub(pa, pb));
    sum = add(sum, scale(add(pa, pb), size / 2));
    weight += size;
  }
  return scale(sum, 1 / (weight || 1));
}
