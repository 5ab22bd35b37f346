/** Elements of the SVG that lies over the limb. */

const NS = "http://www.w3.org/2000/svg";

export function el<K extends keyof SVGElementTagNameMap>(name: K, set: Record<string, string | number> = {}, into?: Element): SVGElementTagNameMap[K] {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(set)) made.setAttribute(key, String(value));
  into?.append(made);
  return made;
}

/** What the limb takes of the screen, in px. */
export interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}
