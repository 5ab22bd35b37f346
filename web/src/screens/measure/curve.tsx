/** Girth over height, with the tape's readings as dots. */
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";

import type { Schemas } from "../../api/client";
import { language, t } from "../../texts";
import type { Reading } from "../readings";

export function Curve({ levels, tape, from }: { levels: readonly Schemas["Level"][]; tape: readonly Reading[]; from: number }) {
  const holder = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!holder.current) return;
    const style = getComputedStyle(holder.current);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const all = [
      ...levels.filter((one) => one.tape_mm).map((one) => [one.height_mm, one.tape_mm?.value ?? null, null] as const),
      ...tape.map((one) => [one.height_mm + from, null, one.girth_mm] as const),
    ].sort((a, b) => a[0] - b[0]);
    if (!all.length) return;
    const axis = { stroke: colour("--ink-3"), grid: { stroke: colour("--line"), width: 1 }, ticks: { show: false }, font: '11px "Inter Variable", sans-serif' };
    const plot = new uPlot(
      {
        width: holder.current.clientWidth,
        height: 150,
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 26 },
          { ...axis, size: 40 },
        ],
        series: [
          {},
          { stroke: colour("--accent"), width: 2, spanGaps: true, points: { show: false } },
          { stroke: colour("--amber"), width: 0, points: { show: true, size: 8, fill: colour("--amber") } },
        ],
      },
      [all.map((p) => p[0]), all.map((p) => p[1]), all.map((p) => p[2])],
      holder.current,
    );
    return () => plot.destroy();
  }, [levels, tape, language.value]);
  return <div ref={holder} class="curve" role="img" aria-label={t("measure.curve")} />;
}
