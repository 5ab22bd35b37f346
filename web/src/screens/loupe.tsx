/** The loupe: what lies under the finger, above the finger, while a place is set by touch. */
import type { RefObject } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import type { Viewer } from "../viewer/viewer";

const SIDE_PX = 112;
const ABOVE_PX = 48;
const ZOOM = 2;

export function Loupe({ viewer, on }: { viewer: RefObject<Viewer | null>; on: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [at, setAt] = useState<{ x: number; y: number } | null>(null);
  useEffect(() => {
    const follow = (event: PointerEvent) => {
      const v = viewer.current;
      if (!on || event.pointerType !== "touch" || !v) return setAt(null);
      const box = v.canvas.getBoundingClientRect();
      setAt({ x: event.clientX - box.left, y: event.clientY - box.top });
    };
    addEventListener("pointermove", follow);
    addEventListener("pointerdown", follow);
    return () => {
      removeEventListener("pointermove", follow);
      removeEventListener("pointerdown", follow);
    };
  }, [on]);
  useEffect(() => {
    const v = viewer.current;
    const ctx = canvas.current?.getContext("2d");
    if (!v || !ctx || !at) return;
    const scale = v.canvas.width / v.canvas.clientWidth;
    const part = (SIDE_PX / ZOOM) * scale;
    v.drawNow();
    ctx.clearRect(0, 0, SIDE_PX, SIDE_PX);
    ctx.drawImage(v.canvas, at.x * scale - part / 2, at.y * scale - part / 2, part, part, 0, 0, SIDE_PX, SIDE_PX);
    ctx.strokeStyle = "#16222A";
    ctx.strokeRect(SIDE_PX / 2 - 8, SIDE_PX / 2, 16, 0);
    ctx.strokeRect(SIDE_PX / 2, SIDE_PX / 2 - 8, 0, 16);
  }, [at]);
  if (!on || !at) return null;
  return (
    <canvas
      ref={canvas}
      class="loupe"
      width={SIDE_PX}
      height={SIDE_PX}
      aria-hidden="true"
      style={{ left: `${at.x - SIDE_PX / 2}px`, top: `${Math.max(0, at.y - SIDE_PX - ABOVE_PX)}px` }}
    />
  );
}
