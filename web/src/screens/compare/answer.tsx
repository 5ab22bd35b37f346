/** What the difference means for the fit, its figures, and how the shapes were laid on each other. */
import { Chip, Notice } from "../../design/parts";
import { fixed, signed, within } from "../../numbers";
import { type TextKey, t, tOr } from "../../texts";
import type { Figures } from "./compared";

/** @param against - In words, what it is compared with. */
export function Answer({ figures, against, busy }: { figures: Figures; against: string; busy: boolean }) {
  const { radial, volume, surface, alignment } = figures;
  const far = alignment.rms_mm !== null && alignment.rms_mm > alignment.far_limit_mm;
  const tone = figures.grade === "alike" ? "green" : figures.grade === "not graded" ? "plain" : "amber";
  const ml = volume.ml;
  return (
    <section class={busy ? "waits" : ""}>
      <h2>{against}</h2>
      <div class="verdict">
        <Chip tone={tone}>{tOr(`grade.${figures.grade}`, figures.grade)}</Chip>
        <p class="lead-line">
          {ml
            ? t(
                ml.difference < 0 ? "compare.less" : "compare.more",
                fixed(Math.abs(ml.difference), 1),
                volume.within_ml === null ? "" : ` ± ${within(volume.within_ml, 1)}`,
                fixed(100 * Math.abs(ml.share ?? 0), 1),
              )
            : t("compare.no.volume")}
        </p>
      </div>
      <div class="fig">
        <div>
          <h3>{t("compare.size")}</h3>
          <b>{radial ? `${signed(radial.mean_radial_error_mm, 2)} mm` : "–"}</b>
          <span class="small faint">{radial ? t("compare.limit", fixed(radial.mean_limit_mm, 2)) : ""}</span>
        </div>
        <div>
          <h3>{t("compare.shape")}</h3>
          <b>{radial ? `${fixed(radial.interquartile_range_mm, 2)} mm` : "–"}</b>
          <span class="small faint">{radial ? t("compare.limit", fixed(radial.range_limit_mm, 2)) : ""}</span>
        </div>
        <div>
          <h3>{t("compare.within")}</h3>
          <b>{fixed(surface.on_second.p95_mm, 2)} mm</b>
          <span class="small faint">{t("compare.largest", fixed(surface.on_second.largest_mm, 1))}</span>
        </div>
      </div>
      <p class="soft small-note" role="status">
        {t(`compare.laid.${alignment.way}` as TextKey)}
        {alignment.rms_mm !== null && ` ${t("compare.apart", fixed(alignment.rms_mm, 2))}`}
        {alignment.slide_within_mm !== null && ` ${t("compare.slide", within(alignment.slide_within_mm, 1))}`}
        {` ${t("compare.share", fixed(100 * surface.on_second.compared_share, 0))}`}
      </p>
      {far && (
        <Notice tone="amber" title={t("compare.far")}>
          {t("compare.far.do")}
        </Notice>
      )}
    </section>
  );
}
