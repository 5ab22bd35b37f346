/** The ruler of heights, and the flag of the level, which a hand or the arrow keys move. */
import { Vector3 } from "three";

import type { Pixel } from "../geometry/nearest";
import type { Section } from "../geometry/section";
import { dragged } from "./drag";
import { type Box, el } from "./svg";
import type { Viewer } from "./viewer";

/** What the ruler shows, and who is told of a level that is chosen on it. */
interface Ruled {
  readonly viewer: Viewer;
  readonly words: { readonly mm: string; readonly level: string };
  readonly section: Section | null;
  readonly span: readonly [number, number] | null;
  readonly onLevel: ((height_mm: number, done: boolean) => void) | null;
}

export class Ruler {
  private readonly ruler: SVGGElement;
  private readonly ticks: SVGGElement;
  private readonly thread: SVGLineElement;
  private readonly flag: SVGGElement;
  private readonly flagText: SVGTextElement;
  private heightAt: (y: number) => number = () => 0;

  constructor(
    private readonly shown: Ruled,
    private readonly svg: SVGSVGElement,
  ) {
    this.ruler = el("g", { class: "ruler", visibility: "hidden" }, svg); // until there is something to measure
    this.ticks = el("g", {}, this.ruler);
    this.thread = el("line", { class: "thread" }, this.ruler);
    this.flag = el("g", { class: "flag", role: "slider", tabindex: 0 }, this.ruler);
    for (const [name, value] of [
      ["label", shown.words.level],
      ["valuemin", "0"],
      ["valuemax", "0"],
      ["valuenow", "0"],
    ] as const)
      this.flag.setAttribute(`aria-${name}`, value);
    el("path", { d: "M0 0l12-13h76a5 5 0 0 1 5 5v16a5 5 0 0 1-5 5H12z" }, this.flag);
    this.flagText = el("text", { x: 17, y: 4.5 }, this.flag);
    el("path", { class: "grip", d: "M76 -3h8M76 3h8" }, this.flag);
    this.listen();
  }

  draw(box: Box): void {
    const span = this.shown.span;
    this.ruler.setAttribute("visibility", span ? "visible" : "hidden");
    if (!span) return;
    const [low, high] = span;
    const width = this.shown.viewer.holder.clientWidth;
    const height = this.shown.viewer.holder.clientHeight;
    let bottom = this.shown.viewer.toScreen(new Vector3(0, 0, low))[1];
    let top = this.shown.viewer.toScreen(new Vector3(0, 0, high))[1];
    if (bottom - top < 0.3 * Math.min(height, (high - low) / Math.max(1e-6, this.shown.viewer.mmPerPixel()))) {
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
    const level = this.shown.section?.height_mm ?? null;
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
    this.flagText.textContent = `${Math.round(level)} ${this.shown.words.mm}`;
    this.flag.setAttribute("aria-label", this.shown.words.level);
    this.flag.setAttribute("aria-valuemin", String(Math.round(low)));
    this.flag.setAttribute("aria-valuemax", String(Math.round(high)));
    this.flag.setAttribute("aria-valuenow", String(Math.round(level)));
    this.flag.setAttribute("aria-valuetext", `${Math.round(level)} mm`);
    let right: Pixel = [box.right, y];
    let most = -Infinity;
    for (const loop of this.shown.section?.loops ?? [])
      for (let i = 0; i < loop.length; i += 4) {
        const at = this.shown.viewer.toScreen(new Vector3(...loop[i]));
        if (at[0] > most) [right, most] = [at, at[0]];
      }
    for (const [k, v] of Object.entries({ x1: right[0], y1: right[1], x2: x - 26, y2: y })) this.thread.setAttribute(k, v.toFixed(1));
  }

  private listen(): void {
    const at = (event: PointerEvent) => {
      const [low, high] = this.shown.span ?? [0, 0];
      const y = event.clientY - this.svg.getBoundingClientRect().top;
      return Math.round(Math.min(high, Math.max(low, this.heightAt(y))));
    };
    this.flag.addEventListener("pointerdown", (down) => {
      this.flag.focus();
      dragged(down, (now, done) => this.shown.onLevel?.(at(now), done));
    });
    this.flag.addEventListener("keydown", (event) => {
      const ways: Record<string, number> = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
      const way = ways[event.key];
      if (!way || !this.shown.span || !this.shown.section) return;
      const next = this.shown.section.height_mm + way * (event.shiftKey ? 10 : 1);
      this.shown.onLevel?.(Math.min(this.shown.span[1], Math.max(this.shown.span[0], next)), true);
      event.preventDefault();
    });
  }
}
