import { beforeEach, expect, test, vi } from "vitest";
import type { Vector3 } from "three";

import { Ruler } from "../src/viewer/ruler";

const HIGH_PX = 400;

/** Stands for an element of SVG. */
class Drawn extends EventTarget {
  readonly set = new Map<string, string>();
  textContent = "";
  setAttribute = (name: string, value: string) => this.set.set(name, value);
  append = () => {};
  replaceChildren = () => {};
  focus = () => {};
  setPointerCapture = () => {};
  getBoundingClientRect = () => ({ left: 0, top: 0 });
}

let page: EventTarget;
let flag: Drawn;
let ruler: Drawn;
let before: string | undefined;
let told: [number, boolean][];

beforeEach(() => {
  page = new EventTarget();
  told = [];
  const made: Drawn[] = [];
  const createElementNS = () => {
    made.push(new Drawn());
    return made.at(-1);
  };
  vi.stubGlobal("window", page);
  vi.stubGlobal("document", { createElementNS });
  const viewer = {
    holder: { clientWidth: 1000, clientHeight: HIGH_PX },
    toScreen: ({ x, z }: Vector3) => [x, HIGH_PX - z],
    mmPerPixel: () => 1,
  };
  const shown = {
    viewer,
    words: { mm: "mm", level: "Level" },
    section: { height_mm: 100, loops: [] },
    span: [0, 300],
    onLevel: (height_mm: number, done: boolean) => void told.push([height_mm, done]),
  };
  const ruled = new Ruler(shown as never, new Drawn() as never);
  ruler = made.find((one) => one.set.get("class") === "ruler")!;
  before = ruler.set.get("visibility");
  ruled.draw({ left: 400, right: 600, top: 100, bottom: 400 });
  flag = made.find((one) => one.set.get("role") === "slider")!;
});

/** As in a page, where what happens on an element reaches the window. */
function pointer(type: string, clientY: number): void {
  for (const target of [flag, page]) target.dispatchEvent(Object.assign(new Event(type), { clientY, pointerId: 1 }));
}

test("the flag follows the hand within the limb", () => {
  pointer("pointerdown", HIGH_PX - 100);
  pointer("pointermove", HIGH_PX - 150);
  pointer("pointermove", HIGH_PX - 350);
  pointer("pointerup", HIGH_PX - 120);
  pointer("pointermove", HIGH_PX - 200);
  expect(told).toEqual([
    [150, false],
    [300, false],
    [120, true],
  ]);
});

test("a pointer that is taken away leaves the flag where it was last", () => {
  pointer("pointerdown", HIGH_PX - 100);
  pointer("pointermove", HIGH_PX - 150);
  pointer("pointercancel", 0);
  expect(told).toEqual([
    [150, false],
    [150, true],
  ]);
});

test("arrow keys move the flag by a millimetre, with shift by ten", () => {
  for (const [key, shiftKey] of [
    ["ArrowUp", false],
    ["ArrowDown", true],
    ["Home", false],
  ] as const)
    flag.dispatchEvent(Object.assign(new Event("keydown"), { key, shiftKey }));
  expect(told).toEqual([
    [101, true],
    [90, true],
  ]);
});

test("until there is a limb to measure, nothing of the ruler is seen", () => {
  expect(before).toBe("hidden");
  expect(ruler.set.get("visibility")).toBe("visible");
});
