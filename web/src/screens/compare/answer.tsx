/** What the difference means for the fit, its figures, and how the shapes were laid on each other. */
import { Chip, Notice } from "../../design/parts";
import { signed } from "../../geometry/scales";
import { type TextKey, t, tOr } from "../../texts";
import type { Figures } from "./compared";

export function Answer({ figures, busy }: { figures: Figures; busy: boolean }) {
  const { radial, volume, surface, alignment } = figures;
  const far = alignment.rms_mm !== null && alignment.rms_mm > alignment.far_limit_mm;
  const tone = figures.grade === "alike" ? "green" : figures.grade === "not graded" ? "plain" : "amber";
  const ml = volume.ml;
  return (
    <section class={busy ? "waits" : ""}>
      <div class="verdict">
        <Chip tone={tone}>{tOr(`grade.${figures.grade}`, figures.grade)}</Chip>
        <p class="lead-line">
          {ml
            ? t(
                ml.difference < 0 ? "compare.less" : "compare.more",
                Math.abs(ml.difference).toFixed(1),
                volume.within_ml === null ? "" : ` ± ${volume.within_ml.toFixed(1)}`,
                (100 * Math.abs(ml.share ?? 0)).toFixed(1),
              )
            : t("compare.no.volume")}
        </p>
      </div>
      <div class="fig">
        <div>
          <h3>{t("compare.size")}</h3>
          <b>{radial ? `${signed(radial.mean_radial_error_mm, 2)} mm` : "–"}</b>
          <span class="small faint">{radial ? t("compare.limit", radial.mean_limit_mm.toFixed(2)) : ""}</span>
        </div>
        <div>
          <h3>{t("compare.shape")}</h3>
          <b>{radial ? `${radial.interquartile_range_mm.toFixed(2)} mm` : "–"}</b>
          <span class="small faint">{radial ? t("compare.limit", radial.range_limit_mm.toFixed(2)) : ""}</span>
        </div>
        <div>
          <h3>{t("compare.within")}</h3>
          <b>{surface.on_second.p95_mm.toFixed(2)} mm</b>
          <span class="small faint">{t("compare.largest", surface.on_second.largest_mm.toFixed(1))}</span>
        </div>
      </div>
      <p class="soft small-note" role="status">
        {t(`compare.laid.${alignment.way}` as TextKey)}
        {alignment.rms_mm !== null && ` ${t("compare.apart", alignment.rms_mm.toFixed(2))}`}
        {alignment.slide_within_mm !== null && ` ${t("compare.slide", alignment.slide_within_mm.toFixed(1))}`}
        {` ${t("compare.share", (100 * surface.on_second.compared_share).toFixed(0))}`}
      </p>
      {far && (
        <Notice tone="amber" title={t("compare.far")}>
          {t("compare.far.do")}
        </Notice>
      )}
    </section>
  );
}
