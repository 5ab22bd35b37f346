/** Girths of both shapes, level by level. */
import { fixed, signed } from "../../numbers";
import { t } from "../../texts";
import { told } from "../../words";
import type { Figures } from "./compared";

export function Levels({ figures, level, onLevel }: { figures: Figures; level: number | null; onLevel: (height_mm: number) => void }) {
  return (
    <section class="tab">
      <table>
        <thead>
          <tr>
            <th class="num">{t("th.height")}</th>
            <th class="num">{t("compare.th.first")}</th>
            <th class="num">{t("compare.th.second")}</th>
            <th class="num">{t("th.change")}</th>
          </tr>
        </thead>
        <tbody>
          {[...figures.levels].reverse().map((one) => {
            const girth = one.tape_mm ?? null;
            const on = level !== null && Math.abs(level - one.height_mm) < 8;
            return (
              <tr
                key={one.height_mm}
                class={`pick ${on ? "on" : ""}`}
                tabIndex={0}
                aria-current={on || undefined}
                title={one.reason ? told(one.reason) : undefined}
                onClick={() => onLevel(one.height_mm)}
                onFocus={() => onLevel(one.height_mm)}
              >
                <td class="num">{fixed(one.height_mm, 0)}</td>
                <td class="num soft">{fixed(girth?.first, 1)}</td>
                <td class="num">{fixed(girth?.second, 1)}</td>
                <td class={`num ${girth && girth.difference < -0.05 ? "neg" : girth && girth.difference > 0.05 ? "pos" : ""}`}>
                  {girth ? signed(girth.difference) : "–"}
                </td>
              </tr>
            );
          })}
        </tbody>
      </table>
      <p class="small faint">{t("compare.girths")}</p>
    </section>
  );
}
