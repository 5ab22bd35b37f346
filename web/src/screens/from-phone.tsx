/**
 * Photos from a phone in the same network: a link and its picture, once the door is switched on.
 *
 * The door is off until somebody here switches it on; it closes by itself, and when it is told to.
 */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";

import { type Schemas, api, taken } from "../api/client";
import { Button, Notice } from "../design/parts";
import { Refusal } from "../design/refusal";
import { useAct } from "../state/asked";
import { t } from "../texts";
import type { Room } from "./room";

const LOOK_MS = 20_000;

export function FromPhone({ room, onClose }: { room: Room; onClose: () => void }) {
  const path = { params: { path: { case_id: room.id } } };
  const door = useSignal<Schemas["Phone"] | null>(null);
  const act = useAct();
  const look = () =>
    act.run(async () => {
      const now = await taken(api.GET("/api/v1/cases/{case_id}/phone", path));
      const shown = door.value;
      door.value = now.open && shown?.url ? { ...now, url: shown.url, qr_svg: shown.qr_svg } : now;
    });
  const open = () =>
    act.run(async () => {
      door.value = await taken(api.POST("/api/v1/cases/{case_id}/phone", path));
    });
  const close = () =>
    act.run(async () => {
      await taken(api.DELETE("/api/v1/cases/{case_id}/phone", path));
      door.value = null;
    });
  useEffect(() => {
    void look();
    const again = window.setInterval(() => {
      if (door.value?.open) void look();
    }, LOOK_MS);
    return () => clearInterval(again);
  }, [room.id]);

  const on = door.value?.open === true;
  const shown = on && door.value?.url ? door.value : null;
  return (
    <section class="from-phone" aria-label={t("capture.phone")}>
      {shown && <img class="qr" src={pictureOf(shown.qr_svg)} alt={t("phone.qr")} width="200" height="200" />}
      <div class="grow">
        <h2 aria-live="polite">{t(shown ? "phone.scan" : on ? "phone.on" : "phone.off")}</h2>
        <p>{shown ? t("phone.once") : t("phone.what")}</p>
        {shown && <p class="mono">{shown.url}</p>}
        {on && <p>{t("phone.closes", Math.max(1, Math.round((door.value?.closes_s ?? 0) / 60)))}</p>}
        {!(on && door.value?.encrypted) && <p class="soft">{t("phone.open.text")}</p>}
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
