/** Lengths between neighbouring landmarks, over the surface. */
import type { Schemas } from "../../api/client";
import { fixed, within } from "../../numbers";
import { t } from "../../texts";
import { term } from "../../words";

/** At most four. */
export function pairsOf(limb: Schemas["LimbReply"] | undefined): [string, string][] {
  const names = limb?.places.map((one) => one.name) ?? [];
  return names.slice(1, 5).map((name, i) => [names[i], name]);
}

export function Lengths({ lengths }: { lengths: readonly Schemas["Length"][] }) {
  return (
    <section>
      <h3>{t("measure.lengths")}</h3>
      <table class="kv">
        <tbody>
          {lengths.map((one) => (
            <tr key={one.start + one.end}>
              <td>
                {term(one.start)} – {term(one.end)}
              </td>
              <td>
                {fixed(one.over_surface_mm.value, 1)} mm
                {one.over_surface_mm.within ? <span class="faint"> ± {within(one.over_surface_mm.within, 1)}</span> : null}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}
