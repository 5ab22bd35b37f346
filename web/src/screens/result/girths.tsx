/** Girths by height: measured by the server once the limb is aligned, until then by this page. */
import type { Schemas } from "../../api/client";
import { cut, heightsOf } from "../../geometry/section";
import { fixed, within } from "../../numbers";
import { t } from "../../texts";
import type { Limb } from "../limb";

/** Heights of this page's own girths. */
const EVERY_MM = 20;
/** So near to the end no girth is read. */
const END_MM = 4;

interface GirthRow {
  readonly height_mm: number;
  readonly girth: number | null;
  readonly within: number | null;
  readonly area_cm2: number | null;
  readonly below_ml: number | null;
  /** Measured by the server; else by this page, from the guessed axis. */
  readonly kept: boolean;
}

export function rowsOf(limb: Limb | null, measures: Schemas["MeasuresReply"] | null): GirthRow[] {
  if (!limb) return [];
  return (measures ? measuredRows(measures) : ownRows(limb)).reverse();
}

function measuredRows({ levels }: Schemas["MeasuresReply"]): GirthRow[] {
  return levels.map((one) => ({
    height_mm: one.height_mm,
    girth: one.tape_mm?.value ?? null,
    within: one.tape_mm?.within ?? null,
    area_cm2: one.area_mm2 ? one.area_mm2.value / 100 : null,
    below_ml: one.volume_below_ml?.value ?? null,
    kept: true,
  }));
}

function ownRows({ fetched, frame }: Limb): GirthRow[] {
  const { positions, indices } = fetched.data;
  const heights = heightsOf(positions, frame);
  let top = 0;
  for (const h of heights) top = Math.max(top, h);
  const rows: GirthRow[] = [];
  for (let height_mm = EVERY_MM; height_mm < top - END_MM; height_mm += EVERY_MM) {
    const { tape_mm, area_mm2 } = cut(positions, indices, heights, height_mm, frame);
    rows.push({
      height_mm,
      girth: Number.isFinite(tape_mm) ? tape_mm : null,
      within: null,
      area_cm2: Number.isFinite(area_mm2) ? area_mm2 / 100 : null,
      below_ml: null,
      kept: false,
    });
  }
  return rows;
}

export function GirthTable({ rows, level, onLevel }: { rows: readonly GirthRow[]; level: number | null; onLevel: (height_mm: number) => void }) {
  const nearest =
    level === null
      ? null
      : rows.reduce<GirthRow | null>((best, one) => (!best || Math.abs(one.height_mm - level) < Math.abs(best.height_mm - level) ? one : best), null);
  return (
    <table class={rows.some((one) => !one.kept) ? "preview" : ""}>
      <thead>
        <tr>
          <th class="num">{t("th.height")}</th>
          <th class="num">{t("th.girth")}</th>
          <th class="num">±</th>
          <th class="num">{t("th.area")}</th>
          <th class="num">{t("th.below")}</th>
        </tr>
      </thead>
      <tbody>
        {rows.map((one) => {
          const on = nearest === one && level !== null && Math.abs(one.height_mm - level) < 10;
          return (
            <tr
              key={one.height_mm}
              class={`pick ${on ? "on" : ""}`}
              tabIndex={0}
              aria-current={on || undefined}
              onClick={() => onLevel(one.height_mm)}
              onFocus={() => onLevel(one.height_mm)}
            >
              <td class="num">{fixed(one.height_mm, 0)}</td>
              <td class="num">{fixed(one.girth, 1)}</td>
              <td class="num soft">{within(one.within, 1)}</td>
              <td class="num soft">{fixed(one.area_cm2, 1)}</td>
              <td class="num soft">{fixed(one.below_ml, 0)}</td>
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}
