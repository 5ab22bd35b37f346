/**
 * The stage: one canvas that shows the limb, and how hands move round it.
 *
 * Turning, moving and coming nearer go about the point under the pointer. A press that moves less
 * than a few pixels is a click. A tool may take presses that begin on the limb; those that begin
 * beside it still turn. Nothing is drawn while nothing changes.
 *
 * The frame shown has its z along the limb, proximal up, y towards the front, x to the patient's right.
 */
import CameraControls from "camera-controls";
import {
  Box3,
  LinearSRGBColorSpace,
  Matrix4,
  OrthographicCamera,
  PerspectiveCamera,
  Quaternion,
  Raycaster,
  Scene,
  Sphere,
  Spherical,
  Vector2,
  Vector3,
  Vector4,
  WebGLRenderer,
} from "three";

import type { Pixel } from "../geometry/nearest";
import { IDENTITY, type Rigid } from "../geometry/vectors";
import { type Hit, type Mode, Surface, type SurfaceData } from "./surface";

CameraControls.install({
  THREE: { Vector2, Vector3, Vector4, Quaternion, Matrix4, Spherical, Box3, Sphere, Raycaster },
});

/** Directions from which the limb can be looked at, as x, y, z of the frame shown. */
export const VIEWS = {
  front: [0, 1, 0],
  back: [0, -1, 0],
  right: [1, 0, 0],
  left: [-1, 0, 0],
  above: [0, 0, 1],
  below: [0, 0, -1],
} as const;
export type View = keyof typeof VIEWS;
/** How a limb is first seen: from the front, turned and from a little above, so that it has depth. */
const HOME = [0.4, 0.88, 0.22] as const;

/** What a tool does with a press that begins on the limb. */
export interface Tool {
  press?(hit: Hit, event: PointerEvent): boolean;
  slide?(hit: Hit | null, event: PointerEvent): void;
  release?(hit: Hit | null, event: PointerEvent): void;
  cancel?(): void;
}

const CLICK_PX = 4;
const TOUCH_CLICK_PX = 10;
const FIELD_DEG = 24;
const REST_MS = 160;
const KEPT = 2;

export class Viewer {
  readonly canvas = document.createElement("canvas");
  surface: Surface | null = null;
  tool: Tool | null = null;
  onClick: ((hit: Hit | null) => void) | null = null;
  onHover: ((hit: Hit | null, event: PointerEvent) => void) | null = null;
  onFrame: (() => void) | null = null;
  /** Told when it becomes parallel or perspective, by a button or a key. */
  onParallel: ((on: boolean) => void) | null = null;

  /** Surfaces shown last: going back to one costs nothing. */
  private kept: Surface[] = [];
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly perspective = new PerspectiveCamera(FIELD_DEG, 1, 10, 10_000);
  private readonly orthographic = new OrthographicCamera(-1, 1, 1, -1, 1, 10_000);
  private camera: PerspectiveCamera | OrthographicCamera = this.perspective;
  private controls: CameraControls;
  private readonly ray = new Raycaster();
  private readonly watch: ResizeObserver;
  private readonly calm = matchMedia("(prefers-reduced-motion: reduce)");
  private asked = 0;
  private last = 0;
  private pressed: { x: number; y: number; id: number; taken: boolean; moved: boolean } | null = null;
  private ended = false;
  private resting = 0;
  private slow = 0;
  /** As it was fitted: a stage of another size fits it again, until somebody turns or moves it. */
  private fitted = false;
  private size = { width: 0, height: 0 };
  private readonly listeners = new AbortController();

  constructor(readonly holder: HTMLElement) {
    this.canvas.className = "limb-canvas";
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "application"); // its keys are its own
    holder.prepend(this.canvas);
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setClearAlpha(0);
    for (const camera of [this.perspective, this.orthographic]) camera.up.set(0, 0, 1);
    this.controls = this.controlsFor(this.perspective);
    this.watch = new ResizeObserver(() => this.resize());
    this.watch.observe(holder);
    this.listen();
    this.resize();
  }

  show(data: SurfaceData, shown_from_mesh: Rigid = IDENTITY, keepView = false): Surface {
    if (this.surface) this.scene.remove(this.surface.group);
    const known = this.kept.find((one) => one.data === data);
    this.kept = this.kept.filter((one) => one !== known);
    this.surface = known ?? new Surface(data);
    this.kept.push(this.surface);
    for (const old of this.kept.splice(0, Math.max(0, this.kept.length - KEPT))) old.dispose();
    this.surface.place(shown_from_mesh);
    this.surface.inParallel(this.isParallel);
    this.scene.add(this.surface.group);
    if (!keepView) void this.look(null, false);
    this.draw();
    return this.surface;
  }

  colourBy(mode: Mode): void {
    this.surface?.colourBy(mode);
    this.draw();
  }

  get isParallel(): boolean {
    return this.camera === this.orthographic;
  }

  /** Parallel or perspective, the limb as large as before. */
  setParallel(on: boolean): void {
    if (on === this.isParallel) return;
    const target = this.controls.getTarget(new Vector3());
    const position = this.controls.getPosition(new Vector3());
    const tangent = Math.tan((FIELD_DEG * Math.PI) / 360);
    const distance = this.isParallel ? this.orthographic.top / this.orthographic.zoom / tangent : position.distanceTo(target);
    const direction = position.sub(target).normalize();
    this.controls.dispose();
    this.camera = on ? this.orthographic : this.perspective;
    this.controls = this.controlsFor(this.camera);
    this.resize();
    const from = target.clone().addScaledVector(direction, on ? Math.max(distance, 2000) : distance);
    void this.controls.setLookAt(from.x, from.y, from.z, target.x, target.y, target.z, false);
    if (on) void this.controls.zoomTo(this.orthographic.top / (distance * tangent), false);
    this.surface?.inParallel(on);
    this.onParallel?.(on);
    this.draw();
  }

  /** From a side of the body, or as it was first seen. */
  async look(view: View | null, smooth = true): Promise<void> {
    const sphere = this.sphere();
    const [x, y, z] = view === null ? HOME : VIEWS[view];
    const direction = new Vector3(x, y, z);
    // From above and from below the front lies at the top, as in every section of the trade.
    if (view === "above") direction.set(0, -0.0005, 1);
    if (view === "below") direction.set(0, 0.0005, -1);
    const distance = this.distanceFor(sphere);
    const from = sphere.center.clone().addScaledVector(direction.normalize(), distance);
    const moving = smooth && !this.calm.matches;
    this.fitted = true;
    this.controls.setOrbitPoint(sphere.center.x, sphere.center.y, sphere.center.z);
    void this.controls.setFocalOffset(0, 0, 0, moving);
    if (this.isParallel) void this.controls.zoomTo(this.zoomFor(sphere), moving);
    const done = this.controls.setLookAt(from.x, from.y, from.z, sphere.center.x, sphere.center.y, sphere.center.z, moving);
    this.draw();
    if (moving) await done;
    this.draw();
  }

  /** All of the limb, from where one looks now. */
  fit(smooth = true): void {
    const sphere = this.sphere();
    const direction = this.camera.getWorldDirection(new Vector3()).negate();
    const from = sphere.center.clone().addScaledVector(direction, this.distanceFor(sphere));
    const moving = smooth && !this.calm.matches;
    this.fitted = true;
    void this.controls.setFocalOffset(0, 0, 0, moving);
    if (this.isParallel) void this.controls.zoomTo(this.zoomFor(sphere), moving);
    void this.controls.setLookAt(from.x, from.y, from.z, sphere.center.x, sphere.center.y, sphere.center.z, moving);
    this.draw();
  }

  /** Look straight at a place, given in the mesh's frame, along its normal. */
  lookAt(point: Vector3, normal: Vector3): void {
    if (!this.surface) return;
    const at = this.surface.toShown(point);
    const along = this.surface.toShown(point.clone().add(normal)).sub(at);
    const distance = this.controls.distance;
    const from = at.clone().addScaledVector(along.normalize(), distance);
    this.fitted = false;
    void this.controls.setLookAt(from.x, from.y, from.z, at.x, at.y, at.z, !this.calm.matches);
    this.draw();
  }

  turn(right_deg: number, up_deg: number): void {
    this.fitted = false;
    void this.controls.rotate((-right_deg * Math.PI) / 180, (-up_deg * Math.PI) / 180, false);
    this.draw();
  }

  shift(right: number, up: number): void {
    this.fitted = false;
    const step = this.mmPerPixel();
    void this.controls.truck(-right * step, up * step, false);
    this.draw();
  }

  nearer(factor: number): void {
    this.fitted = false;
    if (this.isParallel) void this.controls.zoomTo(this.orthographic.zoom * factor, false);
    else void this.controls.dollyTo(this.controls.distance / factor, false);
    this.draw();
  }

  /** Where a point of the frame shown lies on the stage, in CSS pixels. */
  toScreen(shown: Vector3): Pixel {
    const p = shown.clone().project(this.camera);
    return [((p.x + 1) / 2) * this.holder.clientWidth, ((1 - p.y) / 2) * this.holder.clientHeight];
  }

  /** Where a point of the mesh's frame is on the page, in CSS pixels; null where the surface hides it. */
  onPage(point: Vector3, slack_mm?: number): Pixel | null {
    if (!this.surface) return null;
    const shown = this.surface.toShown(point);
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = this.toScreen(shown);
    return this.isSeen(shown, slack_mm) ? [x + box.left, y + box.top] : null;
  }

  /** Whether the surface does not hide a point of the frame shown that lies on it. */
  isSeen(shown: Vector3, slack_mm = 1.5): boolean {
    if (!this.surface) return false;
    const p = shown.clone().project(this.camera);
    this.ray.setFromCamera(new Vector2(p.x, p.y), this.camera);
    this.ray.firstHitOnly = true;
    const found = this.ray.intersectObject(this.surface.mesh, false)[0];
    if (!found) return true;
    return found.distance > this.ray.ray.origin.distanceTo(shown) - slack_mm;
  }

  hitAt(clientX: number, clientY: number): Hit | null {
    if (!this.surface) return null;
    const box = this.canvas.getBoundingClientRect();
    const x = ((clientX - box.left) / box.width) * 2 - 1;
    const y = 1 - ((clientY - box.top) / box.height) * 2;
    this.ray.setFromCamera(new Vector2(x, y), this.camera);
    return this.surface.hit(this.ray);
  }

  /** Millimetres that a pixel covers at the middle of the limb. */
  mmPerPixel(): number {
    const height = this.holder.clientHeight || 1;
    if (this.isParallel) return (this.orthographic.top - this.orthographic.bottom) / this.orthographic.zoom / height;
    const centre = this.sphere().center;
    const depth = centre.clone().applyMatrix4(this.perspective.matrixWorldInverse).z;
    return (2 * Math.tan((FIELD_DEG * Math.PI) / 360) * Math.abs(depth)) / height;
  }

  /** Rows of the camera's rotation: its right, up and backward directions in the frame shown. */
  axes(): { right: Vector3; up: Vector3; back: Vector3 } {
    const e = this.camera.matrixWorld.elements;
    return {
      right: new Vector3(e[0], e[1], e[2]),
      up: new Vector3(e[4], e[5], e[6]),
      back: new Vector3(e[8], e[9], e[10]),
    };
  }

  /** Draw at once, so that the canvas can be read in the same step. */
  drawNow(): void {
    this.render();
  }

  draw(): void {
    if (!this.asked && !this.ended) this.asked = requestAnimationFrame((now) => this.frame(now));
  }

  dispose(): void {
    this.ended = true;
    cancelAnimationFrame(this.asked);
    clearTimeout(this.resting);
    this.listeners.abort();
    this.watch.disconnect();
    this.controls.dispose();
    for (const one of this.kept) one.dispose();
    this.renderer.dispose();
    this.canvas.remove();
  }

  private controlsFor(camera: PerspectiveCamera | OrthographicCamera): CameraControls {
    const c = new CameraControls(camera, this.canvas);
    c.updateCameraUp();
    c.dollyToCursor = true;
    c.smoothTime = 0.08;
    c.draggingSmoothTime = 0.0001;
    c.minDistance = 30;
    c.maxDistance = 6000;
    c.minZoom = 0.02;
    c.maxZoom = 100;
    const A = CameraControls.ACTION;
    c.mouseButtons.left = A.ROTATE;
    c.mouseButtons.right = A.TRUCK;
    c.mouseButtons.middle = A.TRUCK;
    c.mouseButtons.wheel = camera === this.perspective ? A.DOLLY : A.ZOOM;
    c.touches.one = A.TOUCH_ROTATE;
    c.touches.two = camera === this.perspective ? A.TOUCH_DOLLY_TRUCK : A.TOUCH_ZOOM_TRUCK;
    c.touches.three = A.TOUCH_TRUCK;
    for (const name of ["update", "control", "transitionstart"] as const) c.addEventListener(name, () => this.draw());
    c.addEventListener("control", () => (this.fitted = false));
    return c;
  }

  private listen(): void {
    const signal = this.listeners.signal;
    const capture = { signal, capture: true };
    this.canvas.addEventListener("pointerdown", (event) => this.down(event), capture);
    window.addEventListener("pointermove", (event) => this.moved(event), { signal });
    window.addEventListener("pointerup", (event) => this.up(event), { signal });
    window.addEventListener("pointercancel", (event) => this.up(event, true), { signal });
    this.canvas.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { ...capture, passive: false });
    this.canvas.addEventListener("keydown", (event) => this.key(event), { signal });
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault(), { signal });
    this.canvas.addEventListener("webglcontextrestored", () => this.draw(), { signal });
  }

  private down(event: PointerEvent): void {
    if (this.pressed) {
      // A second finger navigates; what the first began is given up.
      if (this.pressed.taken) this.tool?.cancel?.();
      this.pressed = null;
      this.controls.enabled = true;
      return;
    }
    const hit = this.hitAt(event.clientX, event.clientY);
    if (hit) this.controls.setOrbitPoint(hit.shown.x, hit.shown.y, hit.shown.z);
    const taken = event.button === 0 && hit !== null && (this.tool?.press?.(hit, event) ?? false);
    if (taken) {
      this.controls.enabled = false;
      this.canvas.setPointerCapture(event.pointerId);
    }
    if (event.button === 0) this.pressed = { x: event.clientX, y: event.clientY, id: event.pointerId, taken, moved: false };
  }

  private moved(event: PointerEvent): void {
    const p = this.pressed;
    if (!p) {
      if (event.target === this.canvas && this.onHover) this.onHover(this.hitAt(event.clientX, event.clientY), event);
      return;
    }
    if (event.pointerId !== p.id) return;
    const limit = event.pointerType === "touch" ? TOUCH_CLICK_PX : CLICK_PX;
    if (Math.hypot(event.clientX - p.x, event.clientY - p.y) >= limit) p.moved = true;
    if (p.taken) this.tool?.slide?.(this.hitAt(event.clientX, event.clientY), event);
  }

  private up(event: PointerEvent, cancelled = false): void {
    const p = this.pressed;
    if (!p || event.pointerId !== p.id) return;
    this.pressed = null;
    this.controls.enabled = true;
    const hit = this.hitAt(event.clientX, event.clientY);
    if (p.taken) {
      if (cancelled) this.tool?.cancel?.();
      else this.tool?.release?.(hit, event);
    } else if (!p.moved && !cancelled) this.onClick?.(hit);
    this.draw();
  }

  /** Two fingers on a trackpad move the limb; a pinch or a wheel comes nearer. */
  private wheel(event: WheelEvent): void {
    const trackpad = !event.ctrlKey && event.deltaMode === 0 && (event.deltaX !== 0 || Math.abs(event.deltaY) < 40);
    if (!trackpad) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.shift(-event.deltaX, -event.deltaY);
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const views: View[] = ["front", "back", "right", "left", "above", "below"];
    const arrows: Record<string, [number, number]> = {
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
      ArrowUp: [0, 1],
      ArrowDown: [0, -1],
    };
    const way = arrows[event.key];
    if (way && event.shiftKey) this.shift(24 * way[0], 24 * way[1]);
    else if (way) this.turn(6 * way[0], 6 * way[1]);
    else if (event.key === "+" || event.key === "=") this.nearer(1.15);
    else if (event.key === "-") this.nearer(1 / 1.15);
    else if (event.key === "f" || event.key === "F") this.fit();
    else if (event.key === "p" || event.key === "P") this.setParallel(!this.isParallel);
    else if (/^[1-6]$/.test(event.key)) void this.look(views[Number(event.key) - 1]);
    else return;
    event.preventDefault();
  }

  private sphere(): Sphere {
    const g = this.surface?.geometry;
    if (!this.surface || !g?.boundingSphere) return new Sphere(new Vector3(0, 0, 100), 150);
    return g.boundingSphere.clone().applyMatrix4(this.surface.group.matrix);
  }

  private distanceFor(sphere: Sphere): number {
    const aspect = Math.min(1, this.perspective.aspect);
    // On a low stage the legend and the length bar need their share below the limb.
    const room = this.holder.clientHeight < 520 ? 1.5 : 1.2;
    const distance = (sphere.radius * room) / Math.sin((FIELD_DEG * Math.PI) / 360) / aspect;
    return this.isParallel ? Math.max(distance, 2000) : distance;
  }

  private zoomFor(sphere: Sphere): number {
    return (this.orthographic.top * Math.min(1, this.perspective.aspect)) / (sphere.radius * 1.22);
  }

  private resize(): void {
    const width = this.holder.clientWidth || 1;
    const height = this.holder.clientHeight || 1;
    this.perspective.aspect = width / height;
    this.perspective.updateProjectionMatrix();
    this.orthographic.top = 150;
    this.orthographic.bottom = -150;
    this.orthographic.right = (150 * width) / height;
    this.orthographic.left = -this.orthographic.right;
    this.orthographic.updateProjectionMatrix();
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    if (this.fitted && (width !== this.size.width || height !== this.size.height)) this.fit(false);
    this.size = { width, height };
    this.draw();
  }

  private frame(now: number): void {
    this.asked = 0;
    if (this.ended) return;
    const seconds = Math.min(0.1, (now - this.last) / 1000);
    const steady = now - this.last < 250;
    this.last = now;
    const moving = this.controls.update(seconds);
    const began = performance.now();
    this.render();
    if (moving) {
      this.adapt(performance.now() - began, steady);
      this.draw();
    }
  }

  private render(): void {
    this.surface?.settle();
    this.renderer.render(this.scene, this.camera);
    this.onFrame?.();
  }

  /** Half the resolution while moving, where whole frames take too long. */
  private adapt(took_ms: number, steady: boolean): void {
    this.slow = steady && took_ms > 30 ? this.slow + 1 : Math.max(0, this.slow - 1);
    if (this.slow > 2) this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) / 2);
    clearTimeout(this.resting);
    this.resting = window.setTimeout(() => {
      this.slow = 0;
      this.resize();
    }, REST_MS);
  }
}
