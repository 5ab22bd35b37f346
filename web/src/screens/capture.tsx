/**
 * Capture: may the patient go? Photos arrive, the coach says GO or which to add, and from where.
 *
 * What counts as here is what the server holds and has hashed; what is on its way is shown apart.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";

import { ROOT, type Schemas, api, taken } from "../api/client";
import { Icon } from "../design/icons";
import { Button, Confirm, Notice } from "../design/parts";
import { Refusal } from "../design/refusal";
import { newOffer, perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { boardOf, choicesOf, keepChoices, rulerOf, tapeLacks, tapesOf } from "../state/choices";
import { go, href } from "../state/route";
import { filesOf, forgetDone, send, uploads } from "../state/uploads";
import { bytes, t } from "../texts";
import { coachWords, remarkWords, standWords } from "./coach-words";
import { CaptureOptions } from "./capture-options";
import { Dial, type DialData, HIGH_DEG } from "./dial";
import { Expected } from "./expected";
import { FromPhone } from "./from-phone";
import type { Room, RoomProps } from "./room";
import { told } from "../words";

type Check = Schemas["Check"];

const ACCEPTED = "image/*,video/*,.zip,.heic,.heif,.dng,.cr2,.cr3,.nef,.arw,.raf,.orf,.rw2";

export function CaptureScreen({ room }: RoomProps) {
  const path = { params: { path: { case_id: room.id } } };
  const photos = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/photos", path)), [room.id, room.news.photos]);
  const check = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/check", path)), [room.id, room.news.check, room.news.photos]);
  const cameras = useAsked(() => taken(api.GET("/api/v1/cameras", {})), [room.news.photos]);
  const over = useSignal(false);
  const phone = useSignal(false);
  const chosen = useSignal<string | null>(null);
  const anyway = useSignal(false);
  const act = useAct();
  const input = useRef<HTMLInputElement>(null);
  /** Of the run that is asked for: pressed twice it is one. */
  const run = useMemo(newOffer, []);
  const wait = useRef(0);

  const list = photos.value.value;
  const sending = uploads.value.get(room.id) ?? [];
  const moving = sending.filter((one) => one.state !== "here");
  const choices = choicesOf(room.id);
  const said = check.value.value;
  const started = !["empty", "photos"].includes(room.info.state);

  const askCheck = () =>
    act.run(async () => {
      const { cameras: ids } = choicesOf(room.id);
      await perform(room.id, "post", "/api/v1/cases/{case_id}/check", { ...path, body: { cameras: [...ids], board: boardOf(room.id) } }, { done: check.put, again: check.again, lane: `${room.id} check` });
    });
  const arrived = () => {
    void photos.again();
    clearTimeout(wait.current);
    wait.current = window.setTimeout(() => void askCheck(), 600);
  };
  const add = (files: readonly File[]) => {
    if (files.length) send(room.id, files, arrived);
  };
  const looked = useRef(0);
  useEffect(() => {
    if (!list || list.here < 3 || started || !said || said.current || said.state === "running" || looked.current === list.here) return;
    looked.current = list.here;
    clearTimeout(wait.current);
    wait.current = window.setTimeout(() => void askCheck(), 600);
  }, [list?.here, said?.state, said?.current]);
  useEffect(() => () => clearTimeout(wait.current), []);

  const compute = () =>
    act.run(async () => {
      keepChoices(room.id, { ruler_mm: rulerOf(choices) });
      const { cameras: ids, poisson, unscaled } = choices;
      const body: Schemas["JobOptions"] = { cameras: [...ids], board: boardOf(room.id), surface: poisson ? "poisson" : "ball-pivoting", unscaled, distances: [], tapes: tapesOf(choices), triangles: 500_000 };
      await perform(room.id, "post", "/api/v1/cases/{case_id}/job", { ...path, body }, { id: run.idOf(body) });
      run.over();
      go(href.step(room.id, "result"));
    });

  const here = list?.photos.filter((one) => one.state !== "arriving") ?? [];
  const coming = moving.filter((one) => !here.some((photo) => photo.name === one.name));
  const total = here.length + coming.length;
  /** Photos whose header could not be cleaned, or not all of it. */
  const keeping = here.filter((one) => one.kept.length > 0).length;
  const answer = said?.answer ?? null;
  const goes = answer?.go === true && said?.current === true;
  const few = here.length < 3 ? t("capture.few", here.length) : coming.length ? t("capture.coming", coming.length) : tapeLacks(choices) ? t("options.tape.lacks") : null;
  const busy = room.info.state === "computing" || room.info.state === "held";
  const computed = room.info.state === "finished";

  return (
    <main class="capture" id="content" tabIndex={-1}>
      <Banner said={said} photos={here.length} sample={room.info.sample} busy={busy} done={room.info.state === "finished"} off={few ?? (goes || busy ? null : t("capture.not.go"))} onResult={() => go(href.step(room.id, "result"))} onCompute={() => (busy ? go(href.step(room.id, "result")) : void compute())} act={act.busy.value} />
      <div class="cols">
        <section
          class={`photos ${over.value ? "over" : ""}`}
          aria-label={t("capture.photos")}
          onDragOver={(event) => {
            event.preventDefault();
            over.value = true;
          }}
          onDragLeave={() => (over.value = false)}
          onDrop={(event) => {
            event.preventDefault();
            over.value = false;
            if (event.dataTransfer) void filesOf(event.dataTransfer).then(add);
          }}
        >
          <div class="in">
            <Icon name="folder" />
            <span class="grow">{t("capture.drop")}</span>
            <input ref={input} class="unseen" type="file" multiple accept={ACCEPTED} tabIndex={-1} aria-label={t("capture.choose")} id="photo-files" onChange={(event) => {
              add([...(event.currentTarget.files ?? [])]);
              event.currentTarget.value = "";
            }} />
            <Button onClick={() => input.current?.click()}>{t("capture.choose")}</Button>
            <Button icon="qr" pressed={phone.value} onClick={() => (phone.value = !phone.value)}>
              {t("capture.phone")}
            </Button>
          </div>
          {phone.value && <FromPhone room={room} onClose={() => (phone.value = false)} />}
          <Refusal refused={photos.refused.value ?? act.refused.value ?? check.refused.value} />
          <div class="count">
            <h2 aria-live="polite">{coming.length ? t("capture.of", here.length, total) : t("capture.here", here.length)}</h2>
            <span class="small faint">{list ? (coming.length ? t("capture.bytes.of", bytes(list.bytes), bytes(list.bytes + coming.reduce((sum, one) => sum + one.total - one.sent, 0))) : t(keeping ? "capture.bytes.kept" : "capture.bytes", bytes(list.bytes))) : ""}</span>
          </div>
          <div class="grid">
            {here.map((photo, i) => (
              <PhotoTile key={photo.name} room={room} photo={photo} number={i + 1} said={answer?.photos.find((one) => one.name === photo.name)} on={chosen.value === photo.name} onClick={() => (chosen.value = chosen.value === photo.name ? null : photo.name)} />
            ))}
            {coming.map((one) => (
              <div key={one.name} class={`ph wait ${one.state}`} title={one.message || one.name}>
                <span class="where-to">
                  {one.state === "refused" ? t("capture.refused") : one.state === "offline" ? t("capture.offline") : one.name}
                  <br />
                  {one.state === "refused" ? one.name : `${bytes(one.sent)} / ${bytes(one.total)}`}
                </span>
                {one.state !== "refused" && (
                  <svg class="upload-bar" viewBox="0 0 100 4" preserveAspectRatio="none" aria-hidden="true">
                    <rect width={(100 * one.sent) / Math.max(1, one.total)} height="4" />
                  </svg>
                )}
              </div>
            ))}
            {!goes && answer && additions(answer).map((one) => (
              <div key={one.letter} class="ph ask">
                {t("capture.add", one.letter)}
                <br />
                {one.words}
              </div>
            ))}
          </div>
          {coming.some((one) => one.state === "refused") && (
            <Notice tone="red" title={t("capture.refused.some")} action={<Button onClick={() => forgetDone(room.id)}>{t("close")}</Button>}>
              {coming.filter((one) => one.state === "refused").map((one) => (
                <p key={one.name}>
                  <b>{one.name}</b>: {one.message}
                </p>
              ))}
            </Notice>
          )}
          {keeping > 0 && <Notice tone="amber" title={t("capture.kept", keeping)}>{t("capture.kept.why")}</Notice>}
          {coming.some((one) => one.state === "offline") && <Notice tone="amber" title={t("capture.waiting", coming.length)} />}
          {chosen.value && <PhotoNote room={room} name={chosen.value} photo={here.find((one) => one.name === chosen.value)} said={answer?.photos.find((one) => one.name === chosen.value)} onGone={() => {
            chosen.value = null;
            arrived();
          }} />}
          <CaptureOptions room={room} photos={here.length} cameras={cameras.value.value ?? []} choices={choices} onChange={(part) => {
            const asks = () => JSON.stringify([boardOf(room.id), choicesOf(room.id).cameras]);
            const before = asks();
            keepChoices(room.id, part);
            const again = asks() !== before;
            if (here.length > 2 && again) void askCheck();
          }} />
        </section>
        <aside class="pane">
          <div class="scroll" tabIndex={0} role="region" aria-label={t("dial.title")}>
            <section>
              <div class="row-head">
                <h2>{t("dial.title")}</h2>
                <span class="grow" />
                <span class="small faint">{t("dial.how")}</span>
              </div>
              <Dial data={dialOf(answer)} label={answer ? coachWords(answer).lead : t("dial.none")} />
              <p class="dial-legend small soft">
                <span>{t("dial.outer", HIGH_DEG)}</span>
                <span>{t("dial.inner")}</span>
                <b>{t("dial.missing")}</b>
              </p>
            </section>
            {answer && !goes && answer.missing.length > 0 && <HowToStand answer={answer} />}
            {answer?.coverage && <Expected coverage={answer.coverage} />}
            <Findings said={said} onCheck={here.length > 2 ? () => void askCheck() : null} />
          </div>
          {!goes && !busy && here.length > 0 && (
            <div class="next side-by-side">
              <p class="small faint grow">{t(computed ? "capture.again.when" : "capture.left")}</p>
              <Button off={few} onClick={() => (anyway.value = true)}>
                {t(computed ? "capture.again" : "capture.anyway")}
              </Button>
            </div>
          )}
          {anyway.value && !goes && (
            <Confirm title={t(computed ? "capture.again.sure" : "capture.anyway.sure")} yes={t(computed ? "capture.again" : "capture.anyway")} onYes={() => void compute()} onNo={() => (anyway.value = false)}>
              <p>{t(computed ? "capture.again.why" : "capture.anyway.why")}</p>
            </Confirm>
          )}
        </aside>
      </div>
    </main>
  );
}

/** The photos asked for, with the letters that the dial and the tiles show. */
export function additions(answer: NonNullable<Check["answer"]>) {
  const found: { letter: string; azimuth_deg: number; high: boolean; words: string }[] = [];
  for (const gap of answer.missing)
    for (const [i, azimuth] of gap.azimuths_deg.entries()) {
      const high = (gap.elevations_deg[i] ?? 0) >= HIGH_DEG;
      found.push({ letter: String.fromCharCode(65 + (found.length % 26)), azimuth_deg: azimuth, high, words: high ? t("dial.high", sideWords(azimuth)) : sideWords(azimuth) });
    }
  return found.slice(0, 12);
}

/** Where that is, in words, for somebody who stands at photo 1. */
function sideWords(azimuth_deg: number): string {
  const a = ((azimuth_deg % 360) + 360) % 360;
  const words = ["dial.w.front", "dial.w.right.front", "dial.w.right", "dial.w.right.back", "dial.w.back", "dial.w.left.back", "dial.w.left", "dial.w.left.front"] as const;
  return t(words[Math.round(a / 45) % 8]);
}

export function dialOf(answer: Check["answer"] | null | undefined): DialData | null {
  if (!answer) return null;
  const add = additions(answer);
  return {
    photos: answer.photos
      .filter((one) => one.placed && one.azimuth_deg !== null)
      .map((one) => ({ name: one.name, azimuth_deg: one.azimuth_deg as number, elevation_deg: one.elevation_deg ?? 0 })),
    gaps: add.map((one) => ({ from_deg: one.azimuth_deg - 12, to_deg: one.azimuth_deg + 12, high: one.high })),
    add,
  };
}

function Banner({ said, photos, sample, busy, done, off, onCompute, onResult, act }: { said: Check | null; photos: number; sample: boolean; busy: boolean; done: boolean; off: string | null; onCompute: () => void; onResult: () => void; act: boolean }) {
  const answer = said?.answer;
  const running = said?.state === "running";
  const goes = answer?.go === true && said?.current === true;
  /** Computed, and nothing new here. */
  const rests = done && !answer && !running;
  const tone = rests ? "green" : goes ? "green" : answer && !running ? "amber" : said?.state === "refused" ? "amber" : "";
  const lead = busy ? t("capture.computing") : rests ? t("capture.done") : goes ? t("capture.go") : said?.state === "refused" && !running ? t("capture.cannot.check") : answer && !running ? coachWords(answer).lead : running ? t("capture.checking", said?.photos ?? 0) : photos ? t("capture.collect") : t(sample ? "capture.sample" : "capture.begin");
  const why = busy ? "" : rests ? t("capture.done.why") : said?.state === "refused" && !running ? (said.finding ? told(said.finding) : "") : answer && !running ? coachWords(answer).why : running ? t("capture.checking.why") : t(sample && !photos ? "capture.sample.why" : "capture.begin.why");
  return (
    <div class="say" role="status">
      <span class={`mark ${tone}`}>
        <Icon name={goes || rests ? "tick" : tone === "amber" ? "warn" : "camera"} />
      </span>
      <div class="grow">
        <h1 class="lead">{lead}</h1>
        <span class="soft">{why}</span>
      </div>
      {rests ? (
        <Button go trailing="next" onClick={onResult}>
          {t("capture.see")}
        </Button>
      ) : (
        <Button go={goes || busy} off={busy ? null : (off ?? (act ? t("loading") : null))} onClick={onCompute}>
          {t(busy ? "next.watch" : "capture.compute")}
        </Button>
      )}
    </div>
  );
}

function PhotoTile({ room, photo, number, said, on, onClick }: { room: Room; photo: Schemas["Photo"]; number: number; said?: Schemas["CheckedReply"]; on: boolean; onClick: () => void }) {
  const film = /\.(mp4|mov|avi|mkv|webm)$/i.test(photo.name);
  const bad = photo.state === "unusable" || (said !== undefined && !said.counts);
  const remark = photo.state === "unusable" ? t("capture.unusable") : remarkWords(said?.remarks[0]);
  return (
    <button type="button" class={`ph ${bad ? "bad" : ""} ${on ? "on" : ""}`} title={[photo.name, remark].filter(Boolean).join(": ")} onClick={onClick} aria-pressed={on} aria-label={`${number}: ${photo.name} ${remark}`}>
      {film || photo.state === "unusable" ? <Icon name="camera" /> : <img src={`${ROOT}/cases/${room.id}/photos/${encodeURIComponent(photo.name)}/picture?width=320`} alt="" loading="lazy" />}
      <span>{bad && remark ? `${number} ${remark.split(/[,;:.]/)[0].slice(0, 18)}` : number}</span>
    </button>
  );
}

function PhotoNote({ room, name, photo, said, onGone }: { room: Room; name: string; photo?: Schemas["Photo"]; said?: Schemas["CheckedReply"]; onGone: () => void }) {
  const act = useAct();
  if (!photo) return null;
  const remove = () =>
    act.run(async () => {
      await perform(room.id, "delete", "/api/v1/cases/{case_id}/photos/{name}", { params: { path: { case_id: room.id, name } } });
      onGone();
    });
  return (
    <div class="card photo-note">
      <b>{name}</b>
      <p class="soft small-note">
        {[photo.width_px ? `${photo.width_px} × ${photo.height_px}` : "", bytes(photo.bytes), photo.removed.length ? t("capture.removed", photo.removed.join(", ")) : "", photo.kept.length ? t("capture.kept.one", photo.kept.join(", ")) : ""].filter(Boolean).join(". ")}
      </p>
      {(said?.remarks.length || photo.problem) && <p class="small-note">{[photo.problem, ...(said?.remarks ?? []).map(told)].filter(Boolean).join(". ")}</p>}
      <Refusal refused={act.refused.value} />
      <div class="acts">
        <a class="btn" href={`${ROOT}/cases/${room.id}/photos/${encodeURIComponent(name)}/picture?width=2400`} target="_blank" rel="noreferrer">
          {t("capture.large")}
        </a>
        <Button onClick={() => void remove()}>{t("capture.remove")}</Button>
      </div>
    </div>
  );
}

function HowToStand({ answer }: { answer: NonNullable<Check["answer"]> }) {
  const letters = additions(answer).map((one) => one.letter);
  return (
    <section>
      <div class="two">
        <svg width="150" height="132" viewBox="0 0 150 132" class="stand" aria-hidden="true">
          <path class="limb-shape" d="M96 118h34c-2-14 2-24 0-40-2-14-6-34-17-34s-15 20-17 34c-2 16 2 26 0 40z" />
          <path class="floor" d="M84 122h62" />
          <path class="ray" d="M34 24 104 62M26 80h70" />
          <g transform="translate(26 20) rotate(28)" class="lens">
            <rect x="-12" y="-8" width="20" height="16" rx="2.5" />
            <rect x="8" y="-4" width="6" height="8" />
          </g>
          <g transform="translate(18 80)" class="lens">
            <rect x="-12" y="-8" width="20" height="16" rx="2.5" />
            <rect x="8" y="-4" width="6" height="8" />
          </g>
        </svg>
        <div>
          <h2>{letters.length > 1 ? t("capture.photos.letters", letters.slice(0, -1).join(", "), letters[letters.length - 1]) : t("capture.photo.letter", letters[0] ?? "")}</h2>
          {answer.missing.slice(0, 3).map((one) => (
            <p class="soft" key={told(one.asked)}>
              {standWords(
                one,
                one.azimuths_deg.map((azimuth, i) => ((one.elevations_deg[i] ?? 0) >= HIGH_DEG ? t("dial.high", sideWords(azimuth)) : sideWords(azimuth))),
              )}
            </p>
          ))}
          <p class="small faint">{t("coach.same")}</p>
        </div>
      </div>
    </section>
  );
}

function Findings({ said, onCheck }: { said: Check | null; onCheck: (() => void) | null }) {
  const answer = said?.answer;
  if (!answer)
    return (
      <section class="soft small-note">
        <p>{said?.state === "running" ? t("capture.checking.why") : t("capture.check.later")}</p>
        {onCheck && said?.state !== "running" && (
          <div class="acts">
            <Button onClick={onCheck}>{t("capture.check.now")}</Button>
          </div>
        )}
      </section>
    );
  const placed = answer.photos.some((one) => one.placed);
  const sharp = answer.photos.filter((one) => one.counts).length;
  const checks: { ok: boolean; text: string }[] = [
    { ok: placed && answer.missing.length === 0, text: !placed ? t("find.ring.none") : answer.missing.length === 0 ? t("find.ring") : t("find.ring.gap", answer.largest_gap_deg ? Math.round(answer.largest_gap_deg) : "?") },
    { ok: sharp === answer.photos.length, text: t("find.sharp", sharp, answer.photos.length) },
    ...(answer.board_photos === null || answer.board_photos === undefined ? [] : [{ ok: !answer.findings.some((one) => one.code === "coach.board_unseen"), text: t("find.board", answer.board_photos) }]),
    ...(answer.kept_still === null || answer.kept_still === undefined ? [] : [{ ok: answer.kept_still, text: t(answer.kept_still ? "find.still" : "find.moved") }]),
    { ok: answer.photos.every((one) => (one.burnt ?? 0) < 0.02), text: answer.photos.every((one) => (one.burnt ?? 0) < 0.02) ? t("find.light") : t("find.light.bad") },
  ];
  return (
    <section>
      <div class="chk">
        {checks.map((one) => (
          <div key={one.text}>
            <Icon name={one.ok ? "ok" : "warn"} tone={one.ok ? "g" : "a"} />
            {one.text}
          </div>
        ))}
      </div>
      {answer.findings.length > 0 && (
        <ul class="findings small-note soft">
          {answer.findings.map(told).map((one) => (
            <li key={one}>{one}</li>
          ))}
        </ul>
      )}
      {answer.notes.length > 0 && (
        <>
          <h3>{t("find.notes")}</h3>
          <ul class="findings small-note soft">
            {answer.notes.map(told).map((one) => (
              <li key={one}>{one}</li>
            ))}
          </ul>
        </>
      )}
    </section>
  );
}
