/** Cameras: calibrated lenses with age and certificate, and how a new one is calibrated. */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";

import { ROOT, type Schemas, answerOf, api, putFile } from "../api/client";
import { listen } from "../api/events";
import figures from "../api/figures.json";
import { Button, Chip, Confirm, Empty } from "../design/parts";
import { Refusal } from "../design/refusal";
import { fixed } from "../numbers";
import { newOffer, perform } from "../state/acts";
import { useAct, useQuery } from "../state/requests";
import { t, when } from "../texts";
import { told } from "../words";
import { BoardForm, CHECKERBOARD } from "./board-form";
import { placeOf } from "./camera-files";

type Camera = Schemas["CameraReply"];

export function CameraScreen() {
  const asked = useQuery(() => answerOf(api.GET("/api/v1/cameras", {})), []);
  const name = useSignal("");
  const making = useSignal(false);
  const act = useAct();
  const offer = useMemo(newOffer, []);
  useEffect(() => listen("/events", (changed) => changed.includes("cameras") && void asked.again()), []);
  const list = asked.value.value ?? [];
  useEffect(() => {
    if (!list.some((one) => one.state === "calibrating")) return;
    const wait = setInterval(() => void asked.again(), 1500);
    return () => clearInterval(wait);
  }, [list.some((one) => one.state === "calibrating")]);
  const make = () =>
    act.run(async () => {
      const body = { name: name.value.trim() };
      await perform("", "post", "/api/v1/cameras", { body }, { id: offer.idOf(body) });
      offer.over();
      name.value = "";
      making.value = false;
      await asked.again();
    });
  return (
    <main class="cases" id="content" tabIndex={-1}>
      <div class="head">
        <h1>{t("cameras")}</h1>
        <span class="grow" />
        <Button go icon="plus" onClick={() => (making.value = !making.value)}>
          {t("cameras.new")}
        </Button>
      </div>
      <Refusal refused={asked.refused.value ?? act.refused.value} />
      {making.value && (
        <section class="card" onKeyDown={(event) => event.key === "Escape" && (making.value = false)}>
          <label class="stacked">
            <span>{t("cameras.name")}</span>
            <span class="field">
              <input maxLength={80} readOnly={act.busy.value} value={name.value} onInput={(event) => (name.value = event.currentTarget.value)} />
            </span>
            <span class="small faint">{t("cameras.name.how")}</span>
          </label>
          <div class="acts">
            <Button go off={act.busy.value ? t("loading") : name.value.trim() ? null : t("cameras.name")} onClick={() => void make()}>
              {t("cameras.make")}
            </Button>
            <Button onClick={() => (making.value = false)}>{t("cancel")}</Button>
          </div>
        </section>
      )}
      {asked.value.value && list.length === 0 && !making.value && (
        <Empty icon="camera" title={t("cameras.none")}>
          <p>{t("cameras.none.why")}</p>
        </Empty>
      )}
      {list.map((one) => (
        <CameraCard key={one.id} one={one} onChange={() => void asked.again()} />
      ))}
    </main>
  );
}

function CameraCard({ one, onChange }: { one: Camera; onChange: () => void }) {
  const act = useAct();
  const input = useRef<HTMLInputElement>(null);
  const sent = useSignal<[number, number] | null>(null);
  const removing = useSignal(false);
  const board = useSignal(CHECKERBOARD);
  const path = { params: { path: { camera_id: one.id } } };
  const add = (files: File[]) =>
    act.run(async () => {
      try {
        for (const [i, file] of files.entries()) {
          sent.value = [i, files.length];
          await putFile(placeOf(one.id, file), file);
        }
      } finally {
        sent.value = null;
        onChange();
      }
    });
  const calibrate = () =>
    act.run(async () => {
      await perform("", "post", "/api/v1/cameras/{camera_id}/calibrate", { ...path, body: board.value });
      onChange();
    });
  const remove = () =>
    act.run(async () => {
      await perform("", "delete", "/api/v1/cameras/{camera_id}", path);
      onChange();
    });
  const busy = one.state === "calibrating";
  const ready = one.calibrated !== "" && one.focal_mm !== undefined;
  return (
    <section class="card camera-card">
      <div class="row-head">
        <h2>{one.name}</h2>
        <Chip tone={one.calibrated && !busy ? (one.old ? "amber" : "green") : one.state === "refused" ? "red" : "plain"}>
          {busy
            ? t("cameras.calibrating")
            : one.calibrated
              ? one.age_days
                ? t("cameras.age", one.age_days)
                : t("cameras.today")
              : one.state === "refused"
                ? t("case.state.refused")
                : t("cameras.not.yet")}
        </Chip>
        <span class="grow" />
        <Button bare onClick={() => (removing.value = true)}>
          {t("delete")}
        </Button>
      </div>
      <p class="soft">
        {[
          one.label,
          one.focal_mm ? `${fixed(one.focal_mm, 1)} mm` : "",
          one.width_px ? `${one.width_px} × ${one.height_px}` : "",
          one.rms_px ? t("cameras.fit", fixed(one.rms_px, 2)) : "",
          one.calibrated ? when(one.calibrated) : "",
        ]
          .filter(Boolean)
          .join(". ")}
      </p>
      {one.old && <p class="small-note">{t("cameras.old")}</p>}
      {one.finding && <p class="small-note">{told(one.finding)}</p>}
      <Refusal refused={act.refused.value} />
      {removing.value && (
        <Confirm danger title={t("delete.sure", one.name)} yes={t("delete")} onYes={() => void remove()} onNo={() => (removing.value = false)}>
          <p>{t("cameras.delete.what")}</p>
        </Confirm>
      )}
      <div class="camera-body">
        <div>
          <h3>{t("cameras.photos", one.photos)}</h3>
          <p class="small-note soft">{t("cameras.how")}</p>
          <div class="acts">
            <input
              ref={input}
              class="unseen"
              type="file"
              multiple
              tabIndex={-1}
              accept="image/*,.json,.heic,.dng"
              aria-label={t("cameras.add")}
              onChange={(event) => {
                void add([...(event.currentTarget.files ?? [])]);
                event.currentTarget.value = "";
              }}
            />
            <Button off={busy && t("cameras.calibrating")} onClick={() => input.current?.click()}>
              {t("cameras.add")}
            </Button>
            <Button
              go={!ready}
              off={
                busy || act.busy.value
                  ? t("cameras.calibrating")
                  : one.photos < figures.FEWEST_BOARD_PHOTOS
                    ? t("cameras.few", figures.FEWEST_BOARD_PHOTOS)
                    : null
              }
              onClick={() => void calibrate()}
            >
              {t("cameras.calibrate")}
            </Button>
            {one.calibrated && (
              <a class="btn" href={`${ROOT}/cameras/${one.id}/file`}>
                {t("cameras.file")}
              </a>
            )}
          </div>
          {sent.value && (
            <p role="status" class="small soft">
              {t("cameras.sending", sent.value[0] + 1, sent.value[1])}
            </p>
          )}
          <BoardForm board={board} />
        </div>
        {one.certificate && <img src={one.certificate} alt={t("cameras.certificate")} loading="lazy" />}
      </div>
    </section>
  );
}
