/**
 * What is drawn over the limb: the ring of a level with its ruler and flag, landmarks with names,
 * drawn lines, the depth handle, the view cube, the length bar and the directions of the body.
 *
 * It is one SVG whose elements are made once and moved with every frame. Parts of a line that the
 * limb hides are dotted; what is seen has a white halo.
 */
import { Vector3 } from "three";

import type { AxesTurn } from "../geometry/axes-turn";
import type { Pixel } from "../geometry/nearest";
import type { Section } from "../geometry/section";
import { dragged } from "./drag";
import { VIEWS, type View, type Viewer } from "./viewer";

/** Finer than the surface's own scale, so that a hand can stop at half a millimetre. */
const DEPTH_MM_PER_PX = 0.05;

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

export interface Handle {
  readonly point: Vector3;
  readonly normal: Vector3;
  readonly depth_mm: number;
}

export interface Words {
  readonly proximal: string;
  readonly distal: string;
  readonly mm: string;
  readonly faces: Record<View, string>;
  readonly edges: Record<View, readonly [string, string]>;
  readonly level: string;
}

const NS = "http://www.w3.org/2000/svg";

function el<K extends keyof SVGElementTagNameMap>(name: K, set: Record<string, string | number> = {}, into?: Element): SVGElementTagNameMap[K] {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(set)) made.setAttribute(key, String(value));
  into?.append(made);
  return made;
}

interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
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
  onMark: ((name: string) => void) | null = null;
  onView: ((view: View) => void) | null = null;
  onHandle: ((depth_mm: number, done: boolean, fine: boolean) => void) | null = null;

  private readonly ring = el("g", { class: "ring" }, this.svg);
  private readonly ringHidden = el("path", { class: "hidden" }, this.ring);
  private readonly ringHalo = el("path", { class: "halo" }, this.ring);
  private readonly ringSeen = el("path", { class: "seen" }, this.ring);
  private readonly drawn = el("g", { class: "drawn" }, this.svg);
  private readonly ruler = el("g", { class: "ruler" }, this.svg);
  private readonly ticks = el("g", {}, this.ruler);
  private readonly thread = el("line", { class: "thread" }, this.ruler);
  private readonly flag = el("g", { class: "flag", role: "slider", tabindex: 0 }, this.ruler);
  private readonly flagText = el("text", { x: 17, y: 4.5 }, this.flag);
  private readonly places = el("g", { class: "places" }, this.svg);
  private readonly grip = el("g", { class: "depth" }, this.svg);
  private readonly axis = el("g", { class: "axis" }, this.svg);
  private readonly cube = el("g", { "class": "cube", "aria-hidden": "true" }, this.svg);
  private readonly bar = el("g", { class: "bar" }, this.svg);
  private readonly names = el("g", { class: "names" }, this.svg);
  private heightAt: (y: number) => number = () => 0;
  private readonly faces = new Map<View, { polygon: SVGPolygonElement; text: SVGTextElement; group: SVGGElement }>();
  private readonly tags: Record<"top" | "bottom" | "left" | "right", { group: SVGGElement; box: SVGRectElement; big: SVGTextElement; small: SVGTextElement }>;

  constructor(
    private readonly viewer: Viewer,
    public words: Words,
  ) {
    viewer.holder.append(this.svg);
    for (const [name, value] of [
      ["label", words.level],
      ["valuemin", "0"],
      ["valuemax", "0"],
      ["valuenow", "0"],
    ] as const)
      this.flag.setAttribute(`aria-${name}`, value);
    el("path", { d: "M0 0l12-13h76a5 5 0 0 1 5 5v16a5 5 0 0 1-5 5H12z" }, this.flag);
    this.flag.append(this.flagText);
    el("path", { class: "grip", d: "M76 -3h8M76 3h8" }, this.flag);
    for (const view of Object.keys(VIEWS) as View[]) {
      const group = el("g", { class: "face" }, this.cube);
      const polygon = el("polygon", {}, group);
      const text = el("text", {}, group);
      group.addEventListener("click", () => this.onView?.(view));
      this.faces.set(view, { group, polygon, text });
    }
    const tag = () => {
      const group = el("g", { class: "tag-edge" }, this.names);
      const box = el("rect", { width: 28, height: 24, x: -14, y: -34, rx: 4 }, group);
      const big = el("text", { class: "big", y: -17 }, group);
      const small = el("text", { class: "small-text", y: 6 }, group);
      return { group, box, big, small };
    };
    this.tags = { top: tag(), bottom: tag(), left: tag(), right: tag() };
    this.listen();
  }

  remove(): void {
    this.svg.remove();
  }

  update(): void {
    const { viewer } = this;
    if (!viewer.surface) return;
    const box = this.box();
    this.drawRing();
    this.drawLines();
    this.drawRuler(box);
    this.drawMarks(box);
    this.drawHandle();
    this.drawAxes(box);
    this.drawCube();
    this.drawBar();
    this.drawNames(box);
  }

  private listen(): void {
    let dragging = false;
    this.flag.addEventListener("pointerdown", (event) => {
      dragging = true;
      this.flag.setPointerCapture(event.pointerId);
      event.preventDefault();
      this.flag.focus();
    });
    const at = (event: PointerEvent) => {
      const [low, high] = this.span ?? [0, 0];
      const y = event.clientY - this.svg.getBoundingClientRect().top;
      return Math.round(Math.min(high, Math.max(low, this.heightAt(y))));
    };
    this.flag.addEventListener("pointermove", (event) => {
      if (dragging) this.onLevel?.(at(event), false);
    });
    const end = (event: PointerEvent) => {
      if (dragging) this.onLevel?.(at(event), true);
      dragging = false;
    };
    this.flag.addEventListener("pointerup", end);
    this.flag.addEventListener("pointercancel", end);
    this.flag.addEventListener("keydown", (event) => {
      const ways: Record<string, number> = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
      const way = ways[event.key];
      if (!way || !this.span || !this.section) return;
      const next = this.section.height_mm + way * (event.shiftKey ? 10 : 1);
      this.onLevel?.(Math.min(this.span[1], Math.max(this.span[0], next)), true);
      event.preventDefault();
    });
  }

  private screen(shown: Vector3): Pixel {
    return this.viewer.toScreen(shown);
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
      const [x, y] = this.screen(surface.toShown(v));
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
      const here = this.screen(p);
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
          const [cx, cy] = this.screen(p);
          el("circle", { class: "knot", cx, cy, r: 4.5 }, this.drawn);
        }
    }
  }

  private drawRuler(box: Box): void {
    const span = this.span;
    this.ruler.setAttribute("visibility", span ? "visible" : "hidden");
    if (!span) return;
    const [low, high] = span;
    const width = this.viewer.holder.clientWidth;
    const height = this.viewer.holder.clientHeight;
    let bottom = this.screen(new Vector3(0, 0, low))[1];
    let top = this.screen(new Vector3(0, 0, high))[1];
    if (bottom - top < 0.3 * Math.min(height, (high - low) / Math.max(1e-6, this.viewer.mmPerPixel()))) {
      // Looked at along its axis, or upside down: a ruler of its own scale in the middle.
      bottom = height * 0.75;
      top = height * 0.25;
    }
    const perMm = (bottom - top) / (high - low);
    const yOf = (h: number) => bottom - (h - low) * perMm;
    this.heightAt = (y) => low + (bottom - y) / perMm;
    const x = width < 700 ? Math.max(120, Math.min(width - 88, box.right + 60)) : Math.max(120, Math.min(width - 150, box.right + 128));
    this.ticks.replaceChildren();
    el("line", { x1: x, x2: x, y1: yOf(low), y2: yOf(high) }, this.ticks);
    const every = perMm > 1.4 ? 10 : perMm > 0.7 ? 20 : 50;
    const level = this.section?.height_mm ?? null;
    for (let h = Math.ceil(low / every) * every; h <= high; h += every) {
      const whole = h % (2 * every) === 0;
      el("line", { x1: x - (whole ? 10 : 5), x2: x, y1: yOf(h), y2: yOf(h) }, this.ticks);
      if (whole && (level === null || Math.abs(yOf(h) - yOf(level)) > 15)) el("text", { x: x + 8, y: yOf(h) + 4 }, this.ticks).textContent = String(h);
    }
    const shown = level !== null;
    this.flag.setAttribute("visibility", shown ? "inherit" : "hidden");
    this.thread.setAttribute("visibility", shown ? "inherit" : "hidden");
    if (level === null) return;
    const y = yOf(level);
    this.flag.setAttribute("transform", `translate(${x - 22} ${y})`);
    this.flagText.textContent = `${Math.round(level)} ${this.words.mm}`;
    this.flag.setAttribute("aria-label", this.words.level);
    this.flag.setAttribute("aria-valuemin", String(Math.round(low)));
    this.flag.setAttribute("aria-valuemax", String(Math.round(high)));
    this.flag.setAttribute("aria-valuenow", String(Math.round(level)));
    this.flag.setAttribute("aria-valuetext", `${Math.round(level)} mm`);
    let right: Pixel = [box.right, y];
    let most = -Infinity;
    for (const loop of this.section?.loops ?? [])
      for (let i = 0; i < loop.length; i += 4) {
        const at = this.screen(new Vector3(...loop[i]));
        if (at[0] > most) [right, most] = [at, at[0]];
      }
    for (const [k, v] of Object.entries({ x1: right[0], y1: right[1], x2: x - 26, y2: y })) this.thread.setAttribute(k, v.toFixed(1));
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
      const [x, y] = this.screen(shown);
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

  private drawHandle(): void {
    this.grip.replaceChildren();
    const surface = this.viewer.surface;
    if (!this.handle || !surface) return;
    const { point, normal } = this.handle;
    const at = surface.toShown(point);
    const [x, y] = this.screen(at);
    const tip = surface.toShown(point.clone().addScaledVector(normal, 30));
    let [tx, ty] = this.screen(tip);
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
      const start = this.handle?.depth_mm ?? 0;
      const dx = tx - x;
      const dy = ty - y;
      const far = Math.hypot(dx, dy) || 1;
      dragged(down, (now, done) => {
        const px = ((now.clientX - down.clientX) * dx + (now.clientY - down.clientY) * dy) / far;
        this.onHandle?.(start + px * DEPTH_MM_PER_PX, done, now.altKey);
      });
    });
  }

  /**
   * The long axis with a handle at each end: above, a tilt in the plane of the picture; below, a turn
   * about the axis itself. Seen along the axis there is no plane to tilt in, and that handle hides.
   */
  private drawAxes(box: Box): void {
    if (this.holding) return;
    this.axis.replaceChildren();
    const surface = this.viewer.surface;
    if (!this.axes || !surface) return;
    const origin = this.screen(new Vector3());
    const above = this.screen(new Vector3(0, 0, 100));
    const [ux, uy] = [above[0] - origin[0], above[1] - origin[1]];
    const long = Math.hypot(ux, uy);
    if (long < 30) return;
    const reach = Math.max(...[box.top, box.bottom].map((y) => Math.abs(y - origin[1]))) + 30;
    const bound = (p: Pixel): Pixel => [p[0], Math.max(30, Math.min(this.viewer.holder.clientHeight - 62, p[1]))];
    const top = bound([origin[0] + (ux / long) * reach, origin[1] + (uy / long) * reach]);
    const low = bound([origin[0] - (ux / long) * 44, origin[1] - (uy / long) * 44]);
    for (const name of ["stem-halo", "stem"]) el("line", { class: name, x1: low[0], y1: low[1], x2: top[0], y2: top[1] }, this.axis);
    const { back } = this.viewer.axes();
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

  /** While a handle of the axes is held it stays where it was taken. */
  private holding = false;

  private axisKnob(at: Pixel, sign: string, by: (from: PointerEvent, now: PointerEvent) => AxesTurn): void {
    this.knob(this.axis, at, sign).addEventListener("pointerdown", (down) => {
      this.holding = true;
      dragged(down, (now, done) => {
        this.holding = !done;
        this.onAxes?.(by(down, now), done);
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

  private drawCube(): void {
    const { right, up, back } = this.viewer.axes();
    const width = this.viewer.holder.clientWidth;
    // On a phone it is smaller, beside the modes.
    const small = width < 480;
    this.cube.setAttribute("transform", small ? `translate(${width - 46} 46)` : `translate(${width - 70} 66)`);
    const half = small ? 18 : 26;
    const flat = (v: Vector3): Pixel => [v.dot(right) * half, -v.dot(up) * half];
    const across: Record<View, readonly [Vector3, Vector3]> = {
      front: [new Vector3(-1, 0, 0), new Vector3(0, 0, 1)],
      back: [new Vector3(1, 0, 0), new Vector3(0, 0, 1)],
      right: [new Vector3(0, 1, 0), new Vector3(0, 0, 1)],
      left: [new Vector3(0, -1, 0), new Vector3(0, 0, 1)],
      above: [new Vector3(-1, 0, 0), new Vector3(0, -1, 0)],
      below: [new Vector3(-1, 0, 0), new Vector3(0, 1, 0)],
    };
    for (const [view, face] of this.faces) {
      const n = new Vector3(...VIEWS[view]);
      const seen = n.dot(back) > 0.04;
      face.group.setAttribute("visibility", seen ? "inherit" : "hidden");
      if (!seen) continue;
      const [u, v] = across[view];
      const corner = (a: number, b: number) =>
        flat(n.clone().addScaledVector(u, a).addScaledVector(v, b))
          .map((k) => k.toFixed(1))
          .join(",");
      face.polygon.setAttribute("points", [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)].join(" "));
      face.polygon.setAttribute("stroke-dasharray", this.aligned || view === "above" || view === "below" ? "" : "3 2");
      const [ux, uy] = flat(u);
      const [vx, vy] = flat(v);
      const [cx, cy] = flat(n);
      face.text.setAttribute("transform", `matrix(${ux / half} ${uy / half} ${-vx / half} ${-vy / half} ${cx} ${cy})`);
      const word = this.words.faces[view];
      face.text.textContent = word;
      face.text.setAttribute("class", word.length > 2 ? "long" : "");
    }
  }

  private drawBar(): void {
    const per = this.viewer.mmPerPixel();
    const sizes = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500];
    const size = sizes.find((mm) => mm / per > 70) ?? 500;
    const long = size / per;
    const x = this.viewer.holder.clientWidth - 26 - long;
    const y = this.viewer.holder.clientHeight - 50;
    this.bar.replaceChildren();
    el("path", { d: `M${x} ${y - 6}v6h${long}v-6` }, this.bar);
    el("text", { x: x + long / 2, y: y - 10 }, this.bar).textContent = `${size} ${this.words.mm}`;
  }

  private drawNames(box: Box): void {
    const { right, up } = this.viewer.axes();
    const width = this.viewer.holder.clientWidth;
    const height = this.viewer.holder.clientHeight;
    const towards = (way: Vector3): View => {
      let best: View = "front";
      let most = -Infinity;
      for (const view of Object.keys(VIEWS) as View[]) {
        const along = new Vector3(...VIEWS[view]).dot(way);
        if (along > most) [best, most] = [view, along];
      }
      return best;
    };
    const put = (where: keyof typeof this.tags, view: View, x: number, y: number) => {
      const { group, box: frame, big, small } = this.tags[where];
      const [letter, word] = this.words.edges[view];
      const along = view === "above" || view === "below";
      group.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      const unsure = !this.aligned && !along;
      const lettered = view === "left" || view === "right";
      frame.setAttribute("visibility", lettered ? "inherit" : "hidden");
      frame.setAttribute("class", unsure ? "unsure" : "");
      big.textContent = along ? "" : letter + (unsure ? "?" : "");
      big.setAttribute("class", lettered ? "big" : "big word");
      small.textContent = word;
    };
    const middle = Math.max(60, Math.min(width - 60, (box.left + box.right) / 2));
    const bound = (y: number) => Math.max(70, Math.min(height - 78, y));
    const aside = this.axes ? 64 : 0; // beside the handles of the axes
    put("top", towards(up), middle + aside, bound(box.top - 14));
    put("bottom", towards(up.clone().negate()), middle + aside, bound(box.bottom + 28));
    const tools = this.viewer.holder.classList.contains("with-tools") ? 96 : 0; // beside the column of tools
    put("left", towards(right.clone().negate()), 62 + tools, height / 2);
    put("right", towards(right), width - 62, height / 2);
  }
}
