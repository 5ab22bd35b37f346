/**
 * Photos from a phone in the same network: the link, and its picture as a code.
 *
 * Sending is off until somebody here switches it on; it ends by itself, and when it is switched off.
 */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";

import { type Schemas, answerOf, api } from "../api/client";
import { Button, Notice } from "../design/parts";
import { Refusal } from "../design/refusal";
import { useAct } from "../state/requests";
import { t } from "../texts";
import type { OpenCase } from "./open-case";

const LOOK_MS = 20_000;

export function FromPhone({ openCase, onClose }: { openCase: OpenCase; onClose: () => void }) {
  const path = { params: { path: { case_id: openCase.id } } };
  const phone = useSignal<Schemas["Phone"] | null>(null);
  const act = useAct();
  const look = () =>
    act.run(async () => {
      const now = await answerOf(api.GET("/api/v1/cases/{case_id}/phone", path));
      const shown = phone.value;
      phone.value = now.open && shown?.url ? { ...now, url: shown.url, qr_svg: shown.qr_svg } : now;
    });
  const open = () =>
    act.run(async () => {
      phone.value = await answerOf(api.POST("/api/v1/cases/{case_id}/phone", path));
    });
  const close = () =>
    act.run(async () => {
      await answerOf(api.DELETE("/api/v1/cases/{case_id}/phone", path));
      phone.value = null;
    });
  useEffect(() => {
    void look();
    const again = window.setInterval(() => {
      if (phone.value?.open) void look();
    }, LOOK_MS);
    return () => clearInterval(again);
  }, [openCase.id]);

  const on = phone.value?.open === true;
  const shown = on && phone.value?.url ? phone.value : null;
  return (
    <section class="from-phone" aria-label={t("capture.phone")}>
      {shown && <img class="qr" src={pictureOf(shown.qr_svg)} alt={t("phone.qr")} width="200" height="200" />}
      <div class="grow">
        <h2 aria-live="polite">{t(shown ? "phone.scan" : on ? "phone.on" : "phone.off")}</h2>
        <p>{shown ? t("phone.once") : t("phone.what")}</p>
        {shown && <p class="mono">{shown.url}</p>}
        {on && <p>{t("phone.closes", Math.max(1, Math.round((phone.value?.closes_s ?? 0) / 60)))}</p>}
        {!(on && phone.value?.encrypted) && <p class="soft">{t("phone.open.text")}</p>}
        <p class="soft">{t("phone.ios")}</p>
        <div class="acts">
          {shown ? (
            <Button onClick={() => void open()}>{t("phone.new")}</Button>
          ) : (
            <Button icon="qr" off={act.busy.value ? t("loading") : null} onClick={() => void open()}>
              {t(on ? "phone.new" : "phone.switch.on")}
            </Button>
          )}
          {on && <Button onClick={() => void close()}>{t("phone.switch.off")}</Button>}
          <Button bare onClick={onClose}>
            {t("close")}
          </Button>
        </div>
        {act.refused.value && (
          <>
            <Refusal refused={act.refused.value} />
            <Notice tone="plain" title={t("phone.cable")} />
          </>
        )}
      </div>
    </section>
  );
}

/** The server's picture as an image: nothing in it can run, whatever it holds. */
function pictureOf(svg: string): string {
  const named = svg.includes("xmlns=") ? svg : svg.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"');
  return `data:image/svg+xml,${encodeURIComponent(named)}`;
}
