import { signal } from "@preact/signals";
import { Vector3 } from "three";
import { beforeEach, expect, test, vi } from "vitest";

import type { Workspace } from "../src/screens/rectify/workspace";
import type { Hit } from "../src/viewer/surface";
import { stubBrowser } from "./browser";

beforeEach(() => {
  stubBrowser();
  vi.resetModules();
});

const hit = (x = 0, y = 0): Hit => ({ face: 0, point: new Vector3(x, y, 0), normal: new Vector3(0, 0, 1), vertex: 0, shown: new Vector3(x, y, 0) });
const at = (clientX: number, clientY: number) => ({ clientX, clientY, pointerType: "mouse" }) as PointerEvent;

function workspace(own: object = {}) {
  const line = signal<readonly Vector3[]>([]);
  const corners = { current: [] as readonly unknown[] };
  const clear = () => {
    line.value = [];
    corners.current = [];
  };
  const drawing = { size: signal(14), soft: signal(8), line, corners, over: signal(null), clear };
  const opened: unknown[] = [];
  const edit = { open: (draft: unknown) => void opened.push(draft) };
  const base = { data: { positions: new Float32Array() } };
  const viewer = { current: { mmPerPixel: () => 1, hitAt: () => null, surface: { normals: new Float32Array() } } };
  const made = { drawing, edit, base, viewer, ...own };
  return { made: made as unknown as Workspace, drawing, opened };
}

test("a second finger takes away no corner of a region that was pressed before", async () => {
  const { regionTool } = await import("../src/screens/rectify/tools/region");
  const { made, drawing } = workspace();
  const tool = regionTool(() => made);
  for (const x of [0, 40]) {
    tool.press?.(hit(x), at(x, 0));
    tool.release?.(hit(x), at(x, 0));
  }
  tool.press?.(hit(80), at(80, 0));
  tool.cancel?.();
  expect(drawing.line.value.map((p) => p.x)).toEqual([0, 40]);
  expect(drawing.corners.current).toHaveLength(2);
});

test("a region that no vertex is in leaves no corner for the next one", async () => {
  const { regionTool } = await import("../src/screens/rectify/tools/region");
  const { made, drawing, opened } = workspace();
  const tool = regionTool(() => made);
  tool.press?.(hit(0), at(0, 0));
  tool.release?.(hit(0), at(0, 0));
  tool.press?.(hit(20), at(20, 0));
  for (let k = 1; k < 12; k++) tool.slide?.(hit(20 + 9 * k), at(20 + 9 * k, 0));
  tool.release?.(hit(), at(0, 0));
  expect(opened).toEqual([]);
  expect([drawing.line.value, drawing.corners.current]).toEqual([[], []]);
});

test("a stroke of the brush whose outline misses the limb leaves no line on it", async () => {
  const { brushTool } = await import("../src/screens/rectify/tools/brush");
  const { made, drawing } = workspace();
  const tool = brushTool(() => made);
  tool.press?.(hit(0), at(0, 0));
  for (let k = 1; k < 12; k++) tool.slide?.(hit(9 * k), at(9 * k, 0));
  expect(drawing.line.value.length).toBeGreaterThan(0);
  tool.release?.(hit(), at(0, 0));
  expect(drawing.line.value).toEqual([]);
});

test("the first point of a trimline closes it when it is pressed, and moves when it is dragged", async () => {
  const { trimlineTool } = await import("../src/screens/rectify/tools/trimline");
  const points = signal<readonly Vector3[]>([0, 1, 2, 3].map((x) => new Vector3(x, 0, 0)));
  const closed = signal(false);
  const { made } = workspace({ trimline: { points, closed, knotAt: () => 0, add: () => {} } });
  const tool = trimlineTool(() => made);
  tool.press?.(hit(0), at(0, 0));
  tool.slide?.(hit(9), at(30, 0));
  tool.release?.(hit(9), at(30, 0));
  expect(closed.value).toBe(false);
  expect(points.value[0].x).toBe(9);
  tool.press?.(hit(9), at(30, 0));
  tool.slide?.(hit(10), at(31, 0));
  tool.release?.(hit(10), at(31, 0));
  expect(closed.value).toBe(true);
  expect(points.value[0].x).toBe(9);
});
