/**
 * The limb's surface on the screen: geometry, colours by mode, picking.
 *
 * Vertices stay in the mesh's frame; the group that holds them carries `shown_from_mesh`, so that
 * what is picked goes to the server in the frame that the server knows.
 */
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, Matrix4, Mesh, type Raycaster, ShaderMaterial, Vector3 } from "three";
import { MeshBVH, acceleratedRaycast } from "three-mesh-bvh";

import { DIFFERENCE_COLOURS, DIFFERENCE_LIMITS_MM, SURE_COLOURS, SURE_STOPS_MM } from "../geometry/scales";
import { type Rigid, columns } from "../geometry/vectors";

export type Mode = "surface" | "photo" | "sure" | "difference";

export interface SurfaceData {
  readonly positions: Float32Array;
  readonly indices: Uint32Array;
  /** One standard deviation of each vertex in mm; NaN where nothing measured it. */
  readonly sigma: Float32Array | null;
  /** Red, green, blue of each vertex, from the photos. */
  readonly colours: Uint8Array | null;
  /** 1 where the surface was filled in, 0 where photos measured it. */
  readonly filled: Uint8Array | null;
}

export interface Hit {
  readonly face: number;
  /** Where, in the mesh's frame. */
  readonly point: Vector3;
  readonly normal: Vector3;
  /** The nearest corner of that triangle. */
  readonly vertex: number;
  /** Where, as shown. */
  readonly shown: Vector3;
}

const MODES: Record<Mode, number> = { surface: 0, photo: 1, sure: 2, difference: 3 };

const VERTEX = /* glsl */ `
attribute vec3 photo;
attribute float sigma;
attribute float difference;
attribute float filled;
varying vec3 vNormal;
varying vec3 vView;
varying vec3 vPhoto;
varying float vSigma;
varying float vDifference;
varying float vFilled;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  vNormal = normalMatrix * normal;
  vView = -seen.xyz;
  vPhoto = photo;
  vSigma = sigma;
  vDifference = difference;
  vFilled = filled;
  gl_Position = projectionMatrix * seen;
}`;

const FRAGMENT = /* glsl */ `
uniform int mode;
uniform vec3 plain;
uniform vec3 sure[6];
uniform float sureStops[6];
uniform vec3 bands[9];
uniform float limits[4];
uniform float wider;
uniform float parallel;
varying vec3 vNormal;
varying vec3 vView;
varying vec3 vPhoto;
varying float vSigma;
varying float vDifference;
varying float vFilled;

vec3 sureColour(float twoSigma) {
  vec3 colour = sure[0];
  for (int i = 0; i < 5; i++) {
    float s = clamp((twoSigma - sureStops[i]) / (sureStops[i + 1] - sureStops[i]), 0.0, 1.0);
    colour = mix(colour, sure[i + 1], s);
  }
  return colour;
}

vec3 bandColour(float d) {
  float size = abs(d);
  int steps = 0;
  for (int i = 0; i < 4; i++) if (size > limits[i] * wider) steps++;
  int at = 4 + (d < 0.0 ? -steps : steps);
  vec3 colour = bands[4];
  for (int i = 0; i < 9; i++) if (i == at) colour = bands[i];
  return colour;
}

void main() {
  vec3 n = normalize(vNormal);
  vec3 v = mix(normalize(vView), vec3(0.0, 0.0, 1.0), parallel);
  float facing = dot(n, v);
  bool inside = !gl_FrontFacing;
  if (inside) { n = -n; }
  float key = max(dot(n, normalize(vec3(-0.35, 0.55, 0.76))), 0.0);
  float fill = max(dot(n, normalize(vec3(0.6, -0.1, 0.8))), 0.0);
  float light = 0.50 + 0.42 * key + 0.16 * fill;
  vec3 base = plain;
  if (mode == 1) base = vPhoto;
  if (mode >= 2) { light = 0.80 + 0.26 * (light - 0.50) / 0.58; }
  if (mode == 2) {
    base = sureColour(2.0 * vSigma);
    if (vFilled > 0.5) {
      float stripe = mod(gl_FragCoord.x + gl_FragCoord.y, 8.0);
      base = stripe < 4.0 ? vec3(0.62) : vec3(0.78);
    }
  }
  if (mode == 3) {
    base = bandColour(vDifference);
    if (vDifference > 1e6) base = mod(gl_FragCoord.x + gl_FragCoord.y, 8.0) < 4.0 ? vec3(0.62) : vec3(0.78);
  }
  if (inside) { base = vec3(0.47, 0.46, 0.45); light = 0.55 + 0.5 * abs(facing); }
  gl_FragColor = vec4(min(base * light, 1.0), 1.0);
}`;

/** Stands for no distance at all: no card draws NaN alike. */
const NOTHING_NEAR = 1e9;

const vec = (hex: string) => {
  const c = new Color().setHex(parseInt(hex.slice(1), 16), "srgb-linear");
  return new Vector3(c.r, c.g, c.b);
};

export class Surface {
  readonly group = new Group();
  readonly geometry = new BufferGeometry();
  readonly mesh: Mesh;
  readonly data: SurfaceData;
  private readonly material: ShaderMaterial;
  private readonly tree: MeshBVH;
  private readonly shown_from_mesh = new Matrix4();
  private readonly mesh_from_shown = new Matrix4();
  private readonly near = { point: new Vector3(), distance: 0, faceIndex: 0 };
  private normalsStale = false;
  private treeStale = false;

  constructor(data: SurfaceData) {
    this.data = data;
    const count = data.positions.length / 3;
    const g = this.geometry;
    g.setAttribute("position", new BufferAttribute(data.positions.slice(), 3));
    g.setIndex(new BufferAttribute(data.indices.slice(), 1));
    g.setAttribute("photo", new BufferAttribute(data.colours ?? new Uint8Array(3 * count).fill(190), 3, true));
    const sigma = new Float32Array(count);
    const filled = new Uint8Array(count);
    for (let i = 0; i < count; i++) {
      const s = data.sigma?.[i];
      sigma[i] = s === undefined || !Number.isFinite(s) ? 1 : s;
      filled[i] = data.filled?.[i] || (data.sigma && !Number.isFinite(data.sigma[i])) ? 1 : 0;
    }
    g.setAttribute("sigma", new BufferAttribute(sigma, 1));
    g.setAttribute("filled", new BufferAttribute(filled, 1));
    g.setAttribute("difference", new BufferAttribute(new Float32Array(count), 1));
    this.tree = new MeshBVH(g, { indirect: true });
    g.boundsTree = this.tree;
    g.computeVertexNormals();
    g.computeBoundingSphere();
    this.material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: DoubleSide,
      uniforms: {
        mode: { value: 0 },
        plain: { value: new Vector3(0.765, 0.745, 0.715) },
        sure: { value: SURE_COLOURS.map(vec) },
        sureStops: { value: [...SURE_STOPS_MM] },
        bands: { value: DIFFERENCE_COLOURS.map(vec) },
        limits: { value: [...DIFFERENCE_LIMITS_MM] },
        wider: { value: 1 },
        parallel: { value: 0 },
      },
    });
    this.mesh = new Mesh(g, this.material);
    this.mesh.raycast = acceleratedRaycast;
    this.mesh.frustumCulled = false;
    this.group.add(this.mesh);
    this.group.matrixAutoUpdate = false;
  }

  get count(): number {
    return this.data.positions.length / 3;
  }

  get positions(): Float32Array {
    return this.geometry.attributes.position.array as Float32Array;
  }

  get normals(): Float32Array {
    return this.geometry.attributes.normal.array as Float32Array;
  }

  place(shown_from_mesh: Rigid): void {
    this.shown_from_mesh.fromArray(columns(shown_from_mesh));
    this.mesh_from_shown.copy(this.shown_from_mesh).invert();
    this.group.matrix.copy(this.shown_from_mesh);
    this.group.updateMatrixWorld(true);
  }

  colourBy(mode: Mode): void {
    this.material.uniforms.mode.value = MODES[mode];
  }

  inParallel(on: boolean): void {
    this.material.uniforms.parallel.value = on ? 1 : 0;
  }

  /** Signed distances in mm to what the surface is compared with, and the factor of the bands; NaN is hatched. */
  showDifference(difference_mm: Float32Array, wider: number): void {
    const attribute = this.geometry.attributes.difference as BufferAttribute;
    const shown = attribute.array as Float32Array;
    shown.set(difference_mm);
    for (let i = 0; i < shown.length; i++) if (!Number.isFinite(shown[i])) shown[i] = NOTHING_NEAR;
    attribute.needsUpdate = true;
    this.material.uniforms.wider.value = wider;
  }

  /** All vertices where the data has them. */
  restore(): void {
    const attribute = this.geometry.attributes.position as BufferAttribute;
    (attribute.array as Float32Array).set(this.data.positions);
    attribute.needsUpdate = true;
    this.normalsStale = true;
    this.treeStale = true;
  }

  /** The nearest place of the surface to a point, both in the mesh's frame; its distance is signed, outward positive. */
  signedDistance(point: Vector3): { signed_mm: number; vertex: number } {
    this.settle();
    this.refit();
    const found = this.tree.closestPointToPoint(point, this.near);
    if (!found) return { signed_mm: 0, vertex: 0 };
    const face = 3 * found.faceIndex;
    const vertex = this.data.indices[face];
    const away = point.clone().sub(found.point);
    const n = this.normals;
    const out = away.x * n[3 * vertex] + away.y * n[3 * vertex + 1] + away.z * n[3 * vertex + 2];
    return { signed_mm: Math.sign(out) * found.distance, vertex };
  }

  /** The point of the surface nearest to one of the mesh's frame. */
  nearest(point: Vector3): Vector3 {
    this.settle();
    this.refit();
    return this.tree.closestPointToPoint(point, this.near)?.point.clone() ?? point;
  }

  /** Other places for some vertices; normals round them follow. */
  move(vertices: Uint32Array, positions: Float32Array): void {
    const attribute = this.geometry.attributes.position as BufferAttribute;
    const array = attribute.array as Float32Array;
    for (let i = 0; i < vertices.length; i++) for (let k = 0; k < 3; k++) array[3 * vertices[i] + k] = positions[3 * i + k];
    attribute.needsUpdate = true;
    this.normalsStale = true;
    this.treeStale = true;
  }

  /** Normals after a move; the frame to come needs them. */
  settle(): void {
    if (!this.normalsStale) return;
    this.geometry.computeVertexNormals();
    this.normalsStale = false;
  }

  hit(ray: Raycaster): Hit | null {
    this.refit();
    ray.firstHitOnly = true;
    const found = ray.intersectObject(this.mesh, false)[0];
    if (!found?.face) return null;
    const point = found.point.clone().applyMatrix4(this.mesh_from_shown);
    const corners = [found.face.a, found.face.b, found.face.c];
    const at = this.positions;
    let vertex = corners[0];
    let least = Infinity;
    for (const c of corners) {
      const d = Math.hypot(at[3 * c] - point.x, at[3 * c + 1] - point.y, at[3 * c + 2] - point.z);
      if (d < least) [vertex, least] = [c, d];
    }
    return { face: found.faceIndex ?? 0, point, normal: found.face.normal.clone(), vertex, shown: found.point };
  }

  private refit(): void {
    if (!this.treeStale) return;
    this.tree.refit();
    this.treeStale = false;
  }

  toShown(point: Vector3): Vector3 {
    return point.clone().applyMatrix4(this.shown_from_mesh);
  }

  toMesh(point: Vector3): Vector3 {
    return point.clone().applyMatrix4(this.mesh_from_shown);
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
  }
}
