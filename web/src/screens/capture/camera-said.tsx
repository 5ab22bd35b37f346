/** What is known of the chosen camera: how old its file is, and whether the photos fit it. */
import type { Schemas } from "../../api/client";
import { Chip, Notice } from "../../design/parts";
import { t } from "../../texts";
import { told } from "../../words";

interface Props {
  readonly camera: Schemas["CameraReply"];
  readonly fits: Schemas["CameraFit"] | null;
}

export function CameraSaid({ camera, fits }: Props) {
  return (
    <div class="camera-said">
      {camera.age_days !== null && camera.age_days !== undefined && (
        <Chip tone={camera.old ? "amber" : "plain"}>{camera.age_days ? t("cameras.age", camera.age_days) : t("cameras.today")}</Chip>
      )}
      {fits?.fits && <Chip tone="green">{t("options.fits")}</Chip>}
      {camera.certificate && (
        <a href={camera.certificate} target="_blank" rel="noreferrer">
          {t("options.certificate")}
        </a>
      )}
      {camera.old && <p class="small-note">{t("cameras.old")}</p>}
      {fits && !fits.fits && (
        <Notice tone="amber" title={t("options.fits.not")}>
          {t("options.fits.do")} {fits.why && told(fits.why)}
        </Notice>
      )}
    </div>
  );
}
