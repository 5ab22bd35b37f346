/** What is known of a point that was clicked: how sure it is, and the photos that measured it. */
import { useEffect, useRef } from "preact/hooks";

import { type Schemas, answerOf, api } from "../api/client";
import { Button } from "../design/parts";
import { Refusal } from "../design/refusal";
import type { Vec3 } from "../geometry/vectors";
import { fixed, within } from "../numbers";
import { useQuery } from "../state/requests";
import { expert } from "../state/settings";
import { t } from "../texts";
import { told } from "../words";
import type { OpenCase } from "./open-case";

const SIDE = 25;

export function PointCard({ openCase, point, onClose }: { openCase: OpenCase; point: Vec3; onClose: () => void }) {
  const asked = useQuery(
    () =>
      answerOf(
        api.POST("/api/v1/cases/{case_id}/surface/point", {
          params: { path: { case_id: openCase.id } },
          body: { position_mm: [point[0], point[1], point[2]] },
        }),
      ),
    [openCase.id, ...point],
  );
  /** What is known of this very point: nothing of the one before while it is asked for, or where it is refused. */
  const found = asked.busy.value || asked.refused.value ? null : asked.value.value;
  const sure = found?.within_mm ?? null;
  return (
    <div class="point-card" role="region" aria-label={t("point.title")}>
      <div class="row-head">
        <b role="status">
          {found ? (found.filled || sure === null ? t("point.filled") : `± ${within(sure, 2)} mm`) : asked.busy.value ? t("loading") : t("point.title")}
        </b>
        <span class="grow" />
        <Button bare icon="close" class="icon-only" label={t("close")} onClick={onClose} />
      </div>
      <Refusal refused={asked.refused.value} />
      {found && (
        <>
          <p class="soft">{found.in_limb_mm ? t("point.height", fixed(found.in_limb_mm[2], 1)) : t("point.unaligned")}</p>
          {expert.value && (
            <p class="mono">
              {found.position_mm.map((v) => v.toFixed(2)).join(", ")} mm
              {found.sigma_mm ? `; σ ${found.sigma_mm.toFixed(4)}` : ""}
            </p>
          )}
          {found.photos.length > 0 && (
            <>
              <p class="soft">{t("point.photos", found.photos.length)}</p>
              <div class="witnesses">
                {found.photos.map((one) => (
                  <Patch key={one.photo} one={one} />
                ))}
              </div>
            </>
          )}
          {found.photos_note && <p class="small faint">{told(found.photos_note)}</p>}
        </>
      )}
    </div>
  );
}

/** The patch of 6 mm as one photo saw it, and how far it is from what all saw. */
function Patch({ one }: { one: Schemas["PointPhoto"] }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const ctx = canvas.current?.getContext("2d");
    const patch = one.patch ?? [];
    if (!ctx || patch.length !== SIDE * SIDE) return;
    const picture = ctx.createImageData(SIDE, SIDE);
    patch.forEach((value, i) => picture.data.set([value, value, value, 255], 4 * i));
    ctx.putImageData(picture, 0, 0);
  }, [one]);
  return (
    <figure title={`${one.photo}, ${one.angle_deg.toFixed(0)}°`}>
      <canvas ref={canvas} width={SIDE} height={SIDE} role="img" aria-label={one.photo} />
      <figcaption class="small faint">
        {one.residual === null || one.residual === undefined ? one.photo.slice(0, 9) : `${fixed(100 * one.residual, 0)} %`}
      </figcaption>
    </figure>
  );
}
