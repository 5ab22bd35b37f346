/**
 * The page of a phone that was let in for one case: photos go in, and it says where to stand next.
 *
 * The server answers a phone for the case, its photos, the coach's answer, and changes of them alone. The
 * check itself is asked for on the clinic machine, where camera and board are chosen.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

import { type Schemas, answerOf, api, link } from "../api/client";
import { listen } from "../api/events";
import { Icon } from "../design/icons";
import { Button, Notice, SideBadge } from "../design/parts";
import { Refusal } from "../design/refusal";
import { bytes } from "../numbers";
import { useQuery } from "../state/requests";
import { type Upload, outstanding, send, uploadName } from "../state/uploads";
import { t } from "../texts";
import { additions, dialOf } from "./capture";
import { pictureOf } from "./photo-picture";
import { RefusedFiles } from "./refused-files";
import { Dial } from "./dial";
import { checkWords, coachWords, remarkWords } from "./coach-words";
import { told } from "../words";

const MOST_ROWS = 5;

export function PhoneScreen({ id }: { id: string }) {
  const path = { params: { path: { case_id: id } } };
  const info = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}", path)), [id]);
  const photos = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/photos", path)), [id]);
  const check = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/check", path)), [id]);
  const pictures = useRef(new Map<string, string>());

  const askAgain = () => {
    void photos.again();
    void check.again();
  };
  useEffect(() => listen(`/cases/${encodeURIComponent(id)}/events`, askAgain), [id]);
  useEffect(() => {
    const gone = () => (link.value = "lost");
    addEventListener("offline", gone);
    addEventListener("online", askAgain);
    document.title = t("phone.title", id);
    return () => {
      removeEventListener("offline", gone);
      removeEventListener("online", askAgain);
    };
  }, [id]);

  const list = photos.value.value;
  const here = list?.photos.filter((one) => one.state !== "arriving") ?? [];
  const { onTheirWay: waiting, refused } = outstanding(id, here);
  const lost = link.value === "lost" || waiting.some((one) => one.state === "offline");
  useEffect(() => {
    if (!waiting.length) return;
    const stay = (event: BeforeUnloadEvent) => event.preventDefault();
    addEventListener("beforeunload", stay);
    return () => removeEventListener("beforeunload", stay);
  }, [waiting.length > 0]);

  const add = (files: readonly File[]) => {
    for (const file of files) pictures.current.set(uploadName(file), URL.createObjectURL(file));
    if (files.length) send(id, files, () => void photos.again());
  };
  const said = check.value.value;
  const answer = said?.answer ?? null;
  const goes = answer?.go === true && said?.current === true && !waiting.length;
  const missing = answer && !goes ? additions(answer) : [];

  return (
    <div class="phone-page">
      <header class="phone-head">
        <span class="case">{id}</span>
        <SideBadge side={info.value.value?.side} />
        <span class="grow" />
        <span class={`net ${lost ? "lost" : ""}`} role="status">
          <Icon name={lost ? "warn" : "network"} small />
          {t(lost ? "phone.no.line" : "phone.line")}
        </span>
      </header>
      <main id="content" tabIndex={-1}>
        <Said said={said} goes={goes} photos={here.length} />
        {lost && (
          <div class="phone-note">
            <Notice tone="amber" title={waiting.length ? t("capture.waiting", waiting.length) : t("phone.lost")}>
              <p>{t("phone.lost.why")}</p>
            </Notice>
          </div>
        )}
        {link.value === "locked" && (
          <div class="phone-note">
            <Notice tone="red" title={t("phone.locked")}>
              <p>{t("phone.locked.why")}</p>
            </Notice>
          </div>
        )}
        {!lost && link.value === "open" && <Refusal refused={info.refused.value ?? photos.refused.value} />}
        {said && answer && <Dial data={dialOf(answer)} label={checkWords(said, answer).lead} />}
        <p class="phone-how">
          {missing.length
            ? [
                t(missing.length > 1 ? "phone.go.to" : "phone.go.one", missing[0].letter, missing[missing.length - 1].letter),
                missing.some((one) => one.high) ? t("phone.high") : "",
                t("phone.same"),
              ]
                .filter(Boolean)
                .join(" ")
            : t(answer ? "phone.same" : "phone.how")}
        </p>
        <section class="phone-state" aria-label={t("phone.sent")}>
          <h2 aria-live="polite">{t("phone.count", here.length, here.length + waiting.length)}</h2>
          <Bar bytes={list?.bytes ?? 0} waiting={list ? waiting : []} />
          <ul class="phone-list">
            {waiting.slice(0, MOST_ROWS).map((one) => (
              <OnItsWay key={one.name} upload={one} picture={pictures.current.get(one.name)} />
            ))}
            {waiting.length > MOST_ROWS && <li class="faint small">{t("phone.and.more", waiting.length - MOST_ROWS)}</li>}
            {here.map((one, i) => (
              <ToTakeAgain key={one.name} id={id} photo={one} number={i + 1} said={answer?.photos.find((other) => other.name === one.name)} />
            ))}
          </ul>
          <RefusedFiles caseId={id} refused={refused} />
          <p class="small faint">{t("phone.ios")}</p>
        </section>
      </main>
      <Shutter go={!goes} letter={missing[0]?.letter ?? null} onFiles={add} />
    </div>
  );
}

/** How many bytes are there, of all. */
function Bar({ bytes: held, waiting }: { bytes: number; waiting: readonly Upload[] }) {
  const sent = waiting.reduce((sum, one) => sum + one.sent, held);
  const total = waiting.reduce((sum, one) => sum + one.total, held);
  return (
    <svg class="phone-bar" viewBox="0 0 100 8" preserveAspectRatio="none" aria-hidden="true">
      <rect class="all" width="100" height="8" />
      <rect class="part" width={total ? (100 * sent) / total : 0} height="8" />
    </svg>
  );
}

interface ShutterProps {
  readonly go: boolean;
  /** Of the photo that is asked for; null where none is. */
  readonly letter: string | null;
  readonly onFiles: (files: readonly File[]) => void;
}

/** Photos are taken, or chosen of those that the phone has. */
function Shutter({ go, letter, onFiles }: ShutterProps) {
  const camera = useRef<HTMLInputElement>(null);
  const library = useRef<HTMLInputElement>(null);
  const take = (input: HTMLInputElement) => {
    onFiles([...(input.files ?? [])]);
    input.value = "";
  };
  const hidden = { "class": "unseen", "type": "file", "accept": "image/*", "tabIndex": -1, "aria-hidden": "true" } as const;
  return (
    <footer class="phone-act">
      <input ref={camera} {...hidden} capture="environment" id="phone-camera" onChange={(event) => take(event.currentTarget)} />
      <input ref={library} {...hidden} multiple id="phone-files" onChange={(event) => take(event.currentTarget)} />
      <Button go={go} icon="camera" onClick={() => camera.current?.click()}>
        {letter ? t("phone.take.letter", letter) : t("phone.take")}
      </Button>
      <button type="button" class="linkish" onClick={() => library.current?.click()}>
        {t("phone.choose")}
      </button>
    </footer>
  );
}

/** The coach's answer in one line. */
function Said({ said, goes, photos }: { said: Schemas["Check"] | null; goes: boolean; photos: number }) {
  const answer = said?.answer;
  const running = said?.state === "running";
  const refused = said?.state === "refused" && !running;
  const tone = goes ? "green" : refused || (answer && !running) ? "amber" : "";
  const lead = goes
    ? t("capture.go")
    : running
      ? t("capture.checking", said?.photos ?? 0)
      : refused
        ? t("capture.cannot.check")
        : answer && !answer.go
          ? notYet(answer)
          : t(photos ? "capture.collect" : "phone.begin");
  const why = running
    ? t("capture.checking.why")
    : refused
      ? said?.finding
        ? told(said.finding)
        : ""
      : answer?.go && answer.kept_still === false
        ? coachWords(answer).why
        : "";
  return (
    <div class="say" role="status">
      <span class={`mark ${tone}`}>
        <Icon name={goes ? "tick" : tone === "amber" ? "warn" : "camera"} />
      </span>
      <div>
        <h1>{lead}</h1>
        {why && <span class="soft">{why}</span>}
      </div>
    </div>
  );
}

/** How many more, and from where; the coach's own headline where photos are not what is missing. */
function notYet(answer: NonNullable<Schemas["Check"]["answer"]>): string {
  const add = additions(answer);
  if (!add.length) return coachWords(answer).lead;
  const ways = [...new Set(add.map((one) => one.words))];
  return t("phone.not.yet", add.length, ways.length < 4 ? ways.join("; ") : t("phone.see.ring"));
}

function OnItsWay({ upload, picture }: { upload: Upload; picture?: string }) {
  const broken = useSignal(false);
  return (
    <li>
      {picture && !broken.value ? <img src={picture} alt="" onError={() => (broken.value = true)} /> : <span class="none" />}
      <span>
        {upload.name}
        <small>
          {upload.state === "offline" ? t("phone.by.itself", bytes(upload.sent), bytes(upload.total)) : t("phone.of", bytes(upload.sent), bytes(upload.total))}
        </small>
      </span>
      <span class="num soft">{Math.floor((100 * upload.sent) / Math.max(1, upload.total))} %</span>
    </li>
  );
}

/** A photo that does not count, and why. */
function ToTakeAgain({ id, photo, number, said }: { id: string; photo: Schemas["Photo"]; number: number; said?: Schemas["CheckedReply"] }) {
  const unusable = photo.state === "unusable";
  if (!unusable && (said === undefined || said.counts)) return null;
  return (
    <li class="bad">
      {unusable ? <span class="none" /> : <img src={pictureOf(id, photo, 320)} alt="" loading="lazy" />}
      <span>
        {t("photo.number", number)}: {unusable ? t("capture.unusable") : remarkWords(said?.remarks[0]) || t("phone.not.counted")}
        <small>{t("phone.again")}</small>
      </span>
      <Icon name="warn" tone="a" />
    </li>
  );
}
