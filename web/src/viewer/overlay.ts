/**
 * What is drawn over the limb: the ring of a level, drawn lines and landmarks with names; with it the
 * ruler, the handles and the directions of the body.
 *
 * It is one SVG whose elements are made once and moved with every frame. Parts of a line that the
 * limb hides are dotted; what is seen has a white halo.
 */
import { Vector3 } from "three";

import type { AxesTurn } from "../geometry/axes-turn";
import type { Pixel } from "../geometry/nearest";
import type { Section } from "../geometry/section";
import { Directions } from "./directions";
import { type Handle, Handles } from "./handles";
import { Ruler } from "./ruler";
import { type Box, el } from "./svg";
import type { View, Viewer } from "./viewer";

export interface Mark {
  readonly name: string;
  readonly label: string;
  /** In the mesh's frame. */
  readonly point: Vector3;
  readonly state: "set" | "guess" | "chosen";
}

export interface Line {
  /** In the mesh's frame. */
  readonly points: readonly Vector3[];
  readonly closed: boolean;
  readonly look: "region" | "trimline" | "draft" | "knots";
  readonly knots?: boolean;
}

export interface Words {
  readonly mm: string;
  readonly faces: Record<View, string>;
  readonly edges: Record<View, readonly [string, string]>;
  readonly level: string;
}

export class Overlay {
  readonly svg = el("svg", { class: "overlay" });
  marks: readonly Mark[] = [];
  lines: readonly Line[] = [];
  handle: Handle | null = null;
  /** Whether the long axis is drawn with its two handles. */
  axes = false;
  /** Told what a hand did to the handles of the axes since it took one. */
  onAxes: ((by: AxesTurn, done: boolean) => void) | null = null;
  section: Section | null = null;
  /** Heights in mm that the ruler spans; null hides it. */
  span: readonly [number, number] | null = null;
  aligned = false;
  onLevel: ((height_mm: number, done: boolean) => void) | null = null;
  onView: ((view: View) => void) | null = null;
  onHandle: ((depth_mm: number, done: boolean, fine: boolean) => void) | null = null;

  private readonly ring = el("g", { class: "ring" }, this.svg);
  private readonly ringHidden = el("path", { class: "hidden" }, this.ring);
  private readonly ringHalo = el("path", { class: "halo" }, this.ring);
  private readonly ringSeen = el("path", { class: "seen" }, this.ring);
  private readonly drawn = el("g", { class: "drawn" }, this.svg);
  private readonly ruler: Ruler;
  private readonly places: SVGGElement;
  private readonly handles: Handles;
  private readonly directions: Directions;

  constructor(
    readonly viewer: Viewer,
    public words: Words,
  ) {
    viewer.holder.append(this.svg);
    // In the order in which they lie over each other.
    this.ruler = new Ruler(this, this.svg);
    this.places = el("g", { class: "places" }, this.svg);
    this.handles = new Handles(this, this.svg);
    this.directions = new Directions(this, this.svg);
  }

  remove(): void {
    this.svg.remove();
  }

  update(): void {
    if (!this.viewer.surface) return;
    const box = this.box();
    this.drawRing();
    this.drawLines();
    this.ruler.draw(box);
    this.drawMarks(box);
    this.handles.draw(box);
    this.directions.draw(box);
  }

  private box(): Box {
    const surface = this.viewer.surface;
    const box: Box = { left: Infinity, right: -Infinity, top: Infinity, bottom: -Infinity };
    const at = surface?.positions;
    if (!surface || !at) return box;
    const step = 3 * Math.max(1, Math.floor(at.length / 3 / 300));
    const v = new Vector3();
    for (let i = 0; i < at.length; i += step) {
      v.set(at[i], at[i + 1], at[i + 2]);
      const [x, y] = this.viewer.toScreen(surface.toShown(v));
      box.left = Math.min(box.left, x);
      box.right = Math.max(box.right, x);
      box.top = Math.min(box.top, y);
      box.bottom = Math.max(box.bottom, y);
    }
    return box;
  }

  private drawRing(): void {
    const hidden: string[] = [];
    const seen: string[] = [];
    for (const loop of this.section?.loops ?? []) {
      const step = Math.max(1, Math.floor(loop.length / 180));
      const points = loop.filter((_, i) => i % step === 0 || i === loop.length - 1).map((p) => new Vector3(...p));
      this.trace(points, false, seen, hidden);
    }
    this.ringHidden.setAttribute("d", hidden.join(""));
    this.ringHalo.setAttribute("d", seen.join(""));
    this.ringSeen.setAttribute("d", seen.join(""));
  }

  /** A line of points as shown, parted into what is seen and what the limb hides. */
  private trace(points: readonly Vector3[], closed: boolean, seen: string[], hidden: string[]): void {
    const all = closed && points.length ? [...points, points[0]] : points;
    let before: Pixel | null = null;
    let open: string[] | null = null;
    for (const p of all) {
      const here = this.viewer.toScreen(p);
      const into = this.viewer.isSeen(p) ? seen : hidden;
      if (into === open) into.push(`L${here[0].toFixed(1)} ${here[1].toFixed(1)}`);
      else {
        if (before) into.push(`M${before[0].toFixed(1)} ${before[1].toFixed(1)}L${here[0].toFixed(1)} ${here[1].toFixed(1)}`);
        else into.push(`M${here[0].toFixed(1)} ${here[1].toFixed(1)}`);
        open = into;
      }
      before = here;
    }
  }

  private drawLines(): void {
    const surface = this.viewer.surface;
    if (!surface) return;
    this.drawn.replaceChildren();
    for (const line of this.lines) {
      const points = line.points.map((p) => surface.toShown(p));
      const seen: string[] = [];
      const hidden: string[] = [];
      if (line.look !== "knots") this.trace(points, line.closed, seen, hidden);
      el("path", { class: "hidden", d: hidden.join("") }, this.drawn);
      el("path", { class: "halo", d: seen.join("") }, this.drawn);
      el("path", { class: line.look, d: seen.join("") }, this.drawn);
      if (line.knots)
        for (const p of points) {
          if (!this.viewer.isSeen(p)) continue;
          const [cx, cy] = this.viewer.toScreen(p);
          el("circle", { class: "knot", cx, cy, r: 4.5 }, this.drawn);
        }
    }
  }

  private drawMarks(box: Box): void {
    const surface = this.viewer.surface;
    if (!surface) return;
    this.places.replaceChildren();
    const middle = (box.left + box.right) / 2;
    const taken: { left: boolean; y: number }[] = [];
    for (const mark of this.marks) {
      const shown = surface.toShown(mark.point);
      const seen = this.viewer.isSeen(shown, 2);
      const [x, y] = this.viewer.toScreen(shown);
      const group = el("g", { "class": `place ${mark.state} ${seen ? "" : "unseen-place"}`, "data-place": mark.name }, this.places);
      if (seen && mark.label) {
        const left = x < middle || (this.span !== null && this.viewer.holder.clientWidth >= 480 && this.viewer.holder.clientWidth < 700);
        const lx = left ? Math.min(x - 30, box.left - 14) : Math.max(x + 30, box.right + 14);
        let ly = y - 22;
        while (taken.some((one) => one.left === left && Math.abs(one.y - ly) < 17)) ly += 17;
        taken.push({ left, y: ly });
        el("line", { x1: x, y1: y, x2: lx, y2: ly }, group);
        const text = el("text", { "x": left ? lx - 4 : lx + 4, "y": ly + 4, "text-anchor": left ? "end" : "start" }, group);
        text.textContent = mark.label;
      }
      el("circle", { class: "dot", cx: x, cy: y, r: mark.state === "chosen" ? 6 : 4.5 }, group);
      if (mark.state === "chosen" && seen) el("path", { class: "cross", d: `M${x - 14} ${y}h8M${x + 6} ${y}h8M${x} ${y - 14}v8M${x} ${y + 6}v8` }, group);
    }
  }
}
