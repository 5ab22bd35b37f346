/** What is drawn with: the tool, how wide it is, and the line that it draws now. */
import { type Signal, signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Vector3 } from "three";

import type { Hit } from "../../viewer/surface";

export type ToolName = "place" | "region" | "brush" | "levels" | "trimline" | "template" | "other";

/** Where a hand was while it drew: on the limb, and on the page in px. */
export interface Touch {
  readonly point: Vector3;
  readonly x: number;
  readonly y: number;
  readonly hit: Hit;
}

export interface Drawing {
  /** The edit by numbers with which the screen was opened. */
  readonly first: "wall" | null;
  readonly tool: Signal<ToolName>;
  /** The brush's radius; the soft edge of the other tools. mm. */
  readonly size: Signal<number>;
  /** Of the brush: how wide its edge falls off, mm. */
  readonly soft: Signal<number>;
  /** The line under the hand. */
  readonly line: Signal<readonly Vector3[]>;
  /** The corners of a region that were set by single presses. */
  readonly corners: RefObject<readonly Touch[]>;
  /** Where the brush would touch the limb now. */
  readonly over: Signal<Hit | null>;
  /** Take away what is drawn and is no edit yet. */
  readonly clear: () => void;
}

/** Sizes of the tool, mm: the least and the most. */
export const SIZE_MM = [4, 60] as const;
export const SOFT_MM = [1, 60] as const;

/** The edit by numbers with which the screen opens, where another one sends somebody here for it. */
export const openWith = signal<"wall" | null>(null);

export function useDrawing(): Drawing {
  /** Asked once: what the screen was opened for. */
  const first = useMemo(() => openWith.value, []);
  useEffect(() => void (openWith.value = null), []);
  const tool = useSignal<ToolName>(first ? "other" : "region");
  const size = useSignal(14);
  const soft = useSignal(8);
  const line = useSignal<readonly Vector3[]>([]);
  const corners = useRef<readonly Touch[]>([]);
  const over = useSignal<Hit | null>(null);
  const clear = () => {
    line.value = [];
    corners.current = [];
  };
  return { first, tool, size, soft, line, corners, over, clear };
}

/** Set a size by so much, within its limits. */
export function sizeBy(of: Signal<number>, by_mm: number, [least, most]: readonly [number, number]): void {
  of.value = Math.max(least, Math.min(most, of.value + by_mm));
}
