/** Cameras and points while a shape is computed, on a plain canvas that turns by dragging. */
import { useEffect, useRef } from "preact/hooks";

import type { Schemas } from "../api/client";
import type { Blocks } from "../api/blocks";
import { t } from "../texts";

export function PointCloud({ cameras, cloud }: { cameras: readonly Schemas["Camera"][]; cloud: Blocks | null }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const turn = useRef({ yaw: 0.6, pitch: 0.35 });
  useEffect(() => {
    const surface = canvas.current;
    const ctx = surface?.getContext("2d");
    if (!surface || !ctx) return;
    const points = (cloud?.blocks.get("positions") as Float32Array | undefined) ?? new Float32Array();
    const colours = cloud?.blocks.get("colours") as Uint8Array | undefined;
    const middle = [0, 0, 0];
    const given = points.length ? points : Float32Array.from(cameras.flatMap((one) => one.centre_mm));
    for (let i = 0; i < given.length; i += 3) for (let k = 0; k < 3; k++) middle[k] += given[i + k] / (given.length / 3);
    let reach = 1;
    for (const one of cameras) reach = Math.max(reach, Math.hypot(...one.centre_mm.map((v, k) => v - middle[k])));
    const draw = () => {
      const width = (surface.width = surface.clientWidth * devicePixelRatio);
      const height = (surface.height = surface.clientHeight * devicePixelRatio);
      const style = getComputedStyle(surface);
      const { yaw, pitch } = turn.current;
      const scale = (0.42 * Math.min(width, height)) / reach;
      const onto = (p: ArrayLike<number>, i = 0): [number, number] => {
        const [x, y, z] = [p[i] - middle[0], p[i + 1] - middle[1], p[i + 2] - middle[2]];
        const sx = x * Math.cos(yaw) + y * Math.sin(yaw);
        const depth = -x * Math.sin(yaw) + y * Math.cos(yaw);
        return [width / 2 + sx * scale, height / 2 - (z * Math.cos(pitch) + depth * Math.sin(pitch)) * scale];
      };
      ctx.clearRect(0, 0, width, height);
      for (let i = 0; i < points.length; i += 3) {
        const [x, y] = onto(points, i);
        ctx.fillStyle = colours ? `rgb(${colours[i]} ${colours[i + 1]} ${colours[i + 2]})` : style.color;
        ctx.fillRect(x, y, 1.6 * devicePixelRatio, 1.6 * devicePixelRatio);
      }
      ctx.strokeStyle = style.getPropertyValue("--accent");
      ctx.lineWidth = 1.4 * devicePixelRatio;
      for (const one of cameras) {
        const size = 0.09 * reach;
        const wide = one.width_px / one.height_px;
        const corner = (a: number, b: number) =>
          one.centre_mm.map((v, k) => v + size * (1.6 * one.forward[k] + a * 0.5 * wide * one.right[k] + b * 0.5 * one.down[k]));
        const eye = onto(one.centre_mm);
        const frame = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)].map((p) => onto(p));
        ctx.beginPath();
        for (const p of frame) {
          ctx.moveTo(...eye);
          ctx.lineTo(...p);
        }
        frame.forEach((p, i) => (i ? ctx.lineTo(...p) : ctx.moveTo(...p)));
        ctx.closePath();
        ctx.stroke();
      }
    };
    const move = (event: PointerEvent) => {
      if (!event.buttons) return;
      turn.current.yaw -= event.movementX * 0.008;
      turn.current.pitch = Math.min(1.5, Math.max(-0.4, turn.current.pitch + event.movementY * 0.006));
      draw();
    };
    const watch = new ResizeObserver(draw);
    watch.observe(surface);
    surface.addEventListener("pointermove", move);
    draw();
    return () => {
      watch.disconnect();
      surface.removeEventListener("pointermove", move);
    };
  }, [cameras, cloud]);
  return (
    <main class="stage" id="content" tabIndex={-1} aria-label={t("job.dots", cameras.length)}>
      <canvas class="dots-canvas" ref={canvas} role="img" aria-label={t("job.dots", cameras.length)} />
      <p class="keys">{t(cloud ? "job.keys.cloud" : "job.keys.cameras", cameras.length)}</p>
    </main>
  );
}
