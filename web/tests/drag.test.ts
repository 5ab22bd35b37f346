import { beforeEach, expect, test, vi } from "vitest";

import { dragged } from "../src/viewer/drag";

let page: EventTarget;

beforeEach(() => {
  page = new EventTarget();
  vi.stubGlobal("window", page);
});

const pointer = (type: string, clientX: number, pointerId = 1) => Object.assign(new Event(type), { clientX, pointerId }) as unknown as PointerEvent;

test("a handle follows the pointer that took it, and no other", () => {
  const told: [number, boolean][] = [];
  dragged(pointer("pointerdown", 0), (now, done) => told.push([now.clientX, done]));
  page.dispatchEvent(pointer("pointermove", 5));
  page.dispatchEvent(pointer("pointermove", 90, 2));
  page.dispatchEvent(pointer("pointerup", 6));
  page.dispatchEvent(pointer("pointermove", 7));
  expect(told).toEqual([
    [5, false],
    [6, true],
  ]);
});

test("a pointer that is taken away lets the handle go where it was last", () => {
  const told: [number, boolean][] = [];
  dragged(pointer("pointerdown", 0), (now, done) => told.push([now.clientX, done]));
  page.dispatchEvent(pointer("pointermove", 5));
  page.dispatchEvent(pointer("pointercancel", 0));
  page.dispatchEvent(pointer("pointermove", 7));
  expect(told).toEqual([
    [5, false],
    [5, true],
  ]);
});
