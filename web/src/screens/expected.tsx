/**
 * What the photos are expected to measure: the limb unrolled, cell by cell, in the colours of "how sure".
 *
 * Columns go round the limb counter-clockwise, photo 1 in the middle; rows go from below upwards. A cell
 * that too few photos see is hatched.
 */
import type { Schemas } from "../api/client";
import { SURE_COLOURS, SURE_STOPS_MM } from "../geometry/scales";
import { t } from "../texts";
import { told } from "../words";

const WIDE = 14;
const HIGH = 9;

/** The colour of ± at the stop below it: cells are no gradient. */
export function sureColour(two_sigma_mm: number): string {
  let at = 0;
  for (let i = 0; i < SURE_STOPS_MM.length; i++) if (two_sigma_mm >= SURE_STOPS_MM[i]) at = i;
  return SURE_COLOURS[at];
}

export function Expected({ coverage }: { coverage: Schemas["CoverageReply"] }) {
  const { rows, columns } = coverage;
  const half = Math.floor(columns / 2);
  return (
    <section>
      <div class="row-head">
        <h2>{t("expected")}</h2>
        <span class="grow" />
        <span class="small faint">{t("expected.share", Math.round(100 * coverage.measured))}</span>
      </div>
      <svg
        class="expected"
        viewBox={`0 0 ${columns * WIDE} ${rows * HIGH}`}
        role="img"
        aria-label={t("expected.label", coverage.weakest ? told(coverage.weakest) : "–")}
      >
        <defs>
          <pattern id="unseen-cells" width="4" height="4" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
            <rect width="4" height="4" class="ground" />
            <rect width="2" height="4" class="stripe" />
          </pattern>
        </defs>
        {coverage.sigma_mm.map((row, r) =>
          row.map((sigma, c) => {
            const seen = coverage.photos[r]?.[c];
            if (seen === null || seen === undefined) return null;
            const x = ((c + half) % columns) * WIDE;
            const y = (rows - 1 - r) * HIGH;
            return <rect key={`${r} ${c}`} x={x} y={y} width={WIDE} height={HIGH} fill={sigma === null ? "url(#unseen-cells)" : sureColour(2 * sigma)} />;
          }),
        )}
      </svg>
      <div class="expected-ways small faint">
        <span>{t("dial.w.back")}</span>
        <span>{t("dial.w.left")}</span>
        <span>{t("dial.w.front")}</span>
        <span>{t("dial.w.right")}</span>
        <span>{t("dial.w.back")}</span>
      </div>
      <p class="small faint">{t("expected.dark")}</p>
    </section>
  );
}
