/** Which way one looks, and how large it is: the view cube, the directions at the edges, the length bar. */
import { Vector3 } from "three";

import type { Pixel } from "../geometry/nearest";
import { type Box, el } from "./svg";
import { VIEWS, type View, type Viewer } from "./viewer";

/** What the directions are called, and who is told of a face of the cube that is clicked. */
interface Directed {
  readonly viewer: Viewer;
  readonly words: {
    readonly mm: string;
    readonly faces: Record<View, string>;
    readonly edges: Record<View, readonly [string, string]>;
  };
  readonly aligned: boolean;
  readonly axes: boolean;
  readonly onView: ((view: View) => void) | null;
}

interface Face {
  readonly group: SVGGElement;
  readonly polygon: SVGPolygonElement;
  readonly text: SVGTextElement;
}

interface Tag {
  readonly group: SVGGElement;
  readonly box: SVGRectElement;
  readonly big: SVGTextElement;
  readonly small: SVGTextElement;
}

export class Directions {
  private readonly cube: SVGGElement;
  private readonly bar: SVGGElement;
  private readonly faces = new Map<View, Face>();
  private readonly tags: Record<"top" | "bottom" | "left" | "right", Tag>;

  constructor(
    private readonly shown: Directed,
    svg: SVGSVGElement,
  ) {
    this.cube = el("g", { "class": "cube", "aria-hidden": "true" }, svg);
    this.bar = el("g", { class: "bar" }, svg);
    const names = el("g", { class: "names" }, svg);
    for (const view of Object.keys(VIEWS) as View[]) {
      const group = el("g", { class: "face" }, this.cube);
      const polygon = el("polygon", {}, group);
      const text = el("text", {}, group);
      group.addEventListener("click", () => this.shown.onView?.(view));
      this.faces.set(view, { group, polygon, text });
    }
    const tag = () => {
      const group = el("g", { class: "tag-edge" }, names);
      const box = el("rect", { width: 28, height: 24, x: -14, y: -34, rx: 4 }, group);
      const big = el("text", { class: "big", y: -17 }, group);
      const small = el("text", { class: "small-text", y: 6 }, group);
      return { group, box, big, small };
    };
    this.tags = { top: tag(), bottom: tag(), left: tag(), right: tag() };
  }

  draw(box: Box): void {
    this.drawCube();
    this.drawBar();
    this.drawNames(box);
  }

  private drawCube(): void {
    const { right, up, back } = this.shown.viewer.axes();
    const width = this.shown.viewer.holder.clientWidth;
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
      face.polygon.setAttribute("stroke-dasharray", this.shown.aligned || view === "above" || view === "below" ? "" : "3 2");
      const [ux, uy] = flat(u);
      const [vx, vy] = flat(v);
      const [cx, cy] = flat(n);
      face.text.setAttribute("transform", `matrix(${ux / half} ${uy / half} ${-vx / half} ${-vy / half} ${cx} ${cy})`);
      const word = this.shown.words.faces[view];
      face.text.textContent = word;
      face.text.setAttribute("class", word.length > 2 ? "long" : "");
    }
  }

  private drawBar(): void {
    const per = this.shown.viewer.mmPerPixel();
    const sizes = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500];
    const size = sizes.find((mm) => mm / per > 70) ?? 500;
    const long = size / per;
    const x = this.shown.viewer.holder.clientWidth - 26 - long;
    const y = this.shown.viewer.holder.clientHeight - 50;
    this.bar.replaceChildren();
    el("path", { d: `M${x} ${y - 6}v6h${long}v-6` }, this.bar);
    el("text", { x: x + long / 2, y: y - 10 }, this.bar).textContent = `${size} ${this.shown.words.mm}`;
  }

  private drawNames(box: Box): void {
    const { right, up } = this.shown.viewer.axes();
    const width = this.shown.viewer.holder.clientWidth;
    const height = this.shown.viewer.holder.clientHeight;
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
      const [letter, word] = this.shown.words.edges[view];
      const along = view === "above" || view === "below";
      group.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      const unsure = !this.shown.aligned && !along;
      const lettered = view === "left" || view === "right";
      frame.setAttribute("visibility", lettered ? "inherit" : "hidden");
      frame.setAttribute("class", unsure ? "unsure" : "");
      big.textContent = along ? "" : letter + (unsure ? "?" : "");
      big.setAttribute("class", lettered ? "big" : "big word");
      small.textContent = word;
    };
    const middle = Math.max(60, Math.min(width - 60, (box.left + box.right) / 2));
    const bound = (y: number) => Math.max(70, Math.min(height - 78, y));
    const aside = this.shown.axes ? 64 : 0; // beside the handles of the axes
    put("top", towards(up), middle + aside, bound(box.top - 14));
    put("bottom", towards(up.clone().negate()), middle + aside, bound(box.bottom + 28));
    const tools = this.shown.viewer.holder.classList.contains("with-tools") ? 96 : 0; // beside the column of tools
    put("left", towards(right.clone().negate()), 62 + tools, height / 2);
    put("right", towards(right), width - 62, height / 2);
  }
}
