/** What a hand takes to move the surface or its axes: the depth handle, and the long axis with a knob at each end. */
import { Vector3 } from "three";

import type { AxesTurn } from "../geometry/axes-turn";
import type { Pixel } from "../geometry/nearest";
import { dragged } from "./drag";
import { type Box, el } from "./svg";
import type { Viewer } from "./viewer";

/** Finer than the surface's own scale, so that a hand can stop at half a millimetre. */
const DEPTH_MM_PER_PX = 0.05;

export interface Handle {
  readonly point: Vector3;
  readonly normal: Vector3;
  readonly depth_mm: number;
}

/** What there is to take, and who is told of it. */
interface Held {
  readonly viewer: Viewer;
  readonly handle: Handle | null;
  readonly onHandle: ((depth_mm: number, done: boolean, fine: boolean) => void) | null;
  readonly axes: boolean;
  readonly onAxes: ((by: AxesTurn, done: boolean) => void) | null;
}

export class Handles {
  private readonly grip: SVGGElement;
  private readonly axis: SVGGElement;
  /** While a handle of the axes is held it stays where it was taken. */
  private holding = false;

  constructor(
    private readonly held: Held,
    private readonly svg: SVGSVGElement,
  ) {
    this.grip = el("g", { class: "depth" }, svg);
    this.axis = el("g", { class: "axis" }, svg);
  }

  draw(box: Box): void {
    this.drawHandle();
    this.drawAxes(box);
  }

  private drawHandle(): void {
    this.grip.replaceChildren();
    const surface = this.held.viewer.surface;
    if (!this.held.handle || !surface) return;
    const { point, normal } = this.held.handle;
    const at = surface.toShown(point);
    const [x, y] = this.held.viewer.toScreen(at);
    const tip = surface.toShown(point.clone().addScaledVector(normal, 30));
    let [tx, ty] = this.held.viewer.toScreen(tip);
    const size = Math.hypot(tx - x, ty - y);
    if (size < 40) {
      const away = size > 4 ? 60 / size : 0;
      [tx, ty] = away ? [x + (tx - x) * away, y + (ty - y) * away] : [x - 60, y + 24];
    } else [tx, ty] = [x + ((tx - x) * 92) / size, y + ((ty - y) * 92) / size];
    el("line", { class: "stem-halo", x1: x, y1: y, x2: tx, y2: ty }, this.grip);
    el("line", { class: "stem", x1: x, y1: y, x2: tx, y2: ty }, this.grip);
    el("circle", { class: "foot", cx: x, cy: y, r: 4 }, this.grip);
    const angle = (Math.atan2(ty - y, tx - x) * 180) / Math.PI;
    const knob = this.knob(this.grip, [tx, ty], "M-5 0h10m-3-3 3 3-3 3m-4-6-3 3 3 3", angle);
    knob.addEventListener("pointerdown", (down) => {
      const start = this.held.handle?.depth_mm ?? 0;
      const dx = tx - x;
      const dy = ty - y;
      const far = Math.hypot(dx, dy) || 1;
      dragged(down, (now, done) => {
        const px = ((now.clientX - down.clientX) * dx + (now.clientY - down.clientY) * dy) / far;
        this.held.onHandle?.(start + px * DEPTH_MM_PER_PX, done, now.altKey);
      });
    });
  }

  /**
   * The long axis with a handle at each end: above, a tilt in the plane of the picture; below, a turn
   * about the axis itself. Seen along the axis there is no plane to tilt in, and both hide.
   */
  private drawAxes(box: Box): void {
    if (this.holding) return;
    this.axis.replaceChildren();
    const surface = this.held.viewer.surface;
    if (!this.held.axes || !surface) return;
    const origin = this.held.viewer.toScreen(new Vector3());
    const above = this.held.viewer.toScreen(new Vector3(0, 0, 100));
    const [ux, uy] = [above[0] - origin[0], above[1] - origin[1]];
    const long = Math.hypot(ux, uy);
    if (long < 30) return;
    const reach = Math.max(...[box.top, box.bottom].map((y) => Math.abs(y - origin[1]))) + 30;
    const bound = (p: Pixel): Pixel => [p[0], Math.max(30, Math.min(this.held.viewer.holder.clientHeight - 62, p[1]))];
    const top = bound([origin[0] + (ux / long) * reach, origin[1] + (uy / long) * reach]);
    const low = bound([origin[0] - (ux / long) * 44, origin[1] - (uy / long) * 44]);
    for (const name of ["stem-halo", "stem"]) el("line", { class: name, x1: low[0], y1: low[1], x2: top[0], y2: top[1] }, this.axis);
    const { back } = this.held.viewer.axes();
    this.axisKnob(top, "M-7 0a9 9 0 0 1 14 0M-7 0l-1-5M-7 0l5 0M7 0l1-5M7 0l-5 0", (from, now) => {
      const angle = (p: PointerEvent) =>
        Math.atan2(-(p.clientY - this.svg.getBoundingClientRect().top - origin[1]), p.clientX - this.svg.getBoundingClientRect().left - origin[0]);
      let by = ((angle(now) - angle(from)) * 180) / Math.PI;
      if (by > 180) by -= 360;
      if (by < -180) by += 360;
      if (now.altKey) by *= 0.2;
      return { turn_deg: 0, flex_deg: by * back.x, lean_deg: by * back.y };
    });
    this.axisKnob(low, "M-8 0h16M-8 0l4-4M-8 0l4 4M8 0l-4-4M8 0l-4 4", (from, now) => ({
      turn_deg: (now.clientX - from.clientX) * (now.altKey ? 0.05 : 0.3),
      flex_deg: 0,
      lean_deg: 0,
    }));
  }

  private axisKnob(at: Pixel, sign: string, by: (from: PointerEvent, now: PointerEvent) => AxesTurn): void {
    this.knob(this.axis, at, sign).addEventListener("pointerdown", (down) => {
      this.holding = true;
      dragged(down, (now, done) => {
        this.holding = !done;
        this.held.onAxes?.(by(down, now), done);
      });
    });
  }

  /** A round handle with its sign, and room round it for a finger. */
  private knob(into: Element, [x, y]: Pixel, sign: string, angle_deg = 0): SVGGElement {
    const knob = el("g", { class: "knob", transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})` }, into);
    el("circle", { class: "reach", r: 24 }, knob);
    el("circle", { class: "face-of-knob", r: 13 }, knob);
    el("path", { d: sign, transform: `rotate(${angle_deg})` }, knob);
    return knob;
  }
}
