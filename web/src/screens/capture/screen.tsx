/**
 * Capture: may the patient go? Photos arrive, the coach says GO or which to add, and from where.
 *
 * What counts as here is what the server holds and has hashed; what is on its way is shown apart.
 */
import { type Signal, useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";

import { Icon } from "../../design/icons";
import { Button, Confirm, Notice } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { bytes } from "../../numbers";
import { tapeLacks } from "../../state/choices";
import { go, href } from "../../state/route";
import { filesOf } from "../../state/uploads";
import { t } from "../../texts";
import { CaptureOptions } from "./options";
import { checkWords } from "../coach-words";
import { Dial, HIGH_DEG } from "../dial";
import { Expected } from "../expected";
import { FromPhone } from "../from-phone";
import { RefusedFiles } from "../refused-files";
import type { CaseProps } from "../open-case";
import { additions, dialOf } from "./additions";
import { Banner } from "./banner";
import { isBusy } from "./banner-words";
import { type Capture, LEAST_PHOTOS, useCapture } from "./capture";
import { Findings } from "./findings";
import { HowToStand } from "./how-to-stand";
import { PhotoNote, PhotoTile, UploadTile } from "./photos";

const ACCEPTED = "image/*,video/*,.zip,.heic,.heif,.dng,.cr2,.cr3,.nef,.arw,.raf,.orf,.rw2";

export function CaptureScreen({ openCase }: CaseProps) {
  const capture = useCapture(openCase);
  const { count, coming, choices, check, goes, act } = capture;
  const few =
    count < LEAST_PHOTOS
      ? t("capture.few", count, LEAST_PHOTOS)
      : coming.onTheirWay.length
        ? t("capture.coming", coming.onTheirWay.length)
        : tapeLacks(choices)
          ? t("options.tape.lacks")
          : null;
  const busy = isBusy(openCase.info);
  const seeResult = () => go(href.step(openCase.id, "result"));
  return (
    <main class="capture" id="content" tabIndex={-1}>
      <Banner
        said={check.value.value}
        info={openCase.info}
        photos={count}
        off={few ?? (goes || busy ? null : t("capture.not.go")) ?? (act.busy.value ? t("loading") : null)}
        onResult={seeResult}
        onCompute={busy ? seeResult : capture.compute}
      />
      <div class="cols">
        <Photos capture={capture} />
        <Coach capture={capture} few={few} busy={busy} />
      </div>
    </main>
  );
}

/** The photos, where they come from, and how they are computed. */
function Photos({ capture }: { capture: Capture }) {
  const { openCase, photos, check, act, here, coming, goes } = capture;
  const over = useSignal(false);
  const phone = useSignal(false);
  const chosen = useSignal<string | null>(null);
  const answer = check.value.value?.answer ?? null;
  const saidOf = (name: string) => answer?.photos.find((one) => one.name === name);
  const photo = here.find((one) => one.name === chosen.value);
  const dragOver = (event: DragEvent) => {
    event.preventDefault();
    over.value = true;
  };
  const drop = (event: DragEvent) => {
    event.preventDefault();
    over.value = false;
    if (event.dataTransfer) void filesOf(event.dataTransfer).then(capture.add);
  };
  const gone = () => {
    chosen.value = null;
    capture.arrived();
  };
  return (
    <section
      class={`photos ${over.value ? "over" : ""}`}
      aria-label={t("capture.photos")}
      onDragOver={dragOver}
      onDragLeave={() => (over.value = false)}
      onDrop={drop}
    >
      <Intake capture={capture} phone={phone} />
      {phone.value && <FromPhone openCase={openCase} onClose={() => (phone.value = false)} />}
      <Refusal refused={photos.refused.value ?? act.refused.value ?? check.refused.value} />
      <Count capture={capture} />
      <div class="grid">
        {here.map((one, i) => (
          <PhotoTile
            key={one.name}
            openCase={openCase}
            photo={one}
            number={i + 1}
            said={saidOf(one.name)}
            on={photo === one}
            onClick={() => (chosen.value = photo === one ? null : one.name)}
          />
        ))}
        {[...coming.onTheirWay, ...coming.refused].map((one) => (
          <UploadTile key={one.name} one={one} />
        ))}
        {!goes &&
          answer &&
          additions(answer).map((one) => (
            <div key={one.letter} class="ph ask">
              {t("capture.add", one.letter)}
              <br />
              {one.words}
            </div>
          ))}
      </div>
      <Notices capture={capture} />
      {photo && <PhotoNote openCase={openCase} photo={photo} said={saidOf(photo.name)} onGone={gone} />}
      <CaptureOptions openCase={openCase} photos={capture.count} cameras={capture.cameras} choices={capture.choices} onChange={capture.choose} />
    </section>
  );
}

/** Files are dropped, chosen, or come from a phone. */
function Intake({ capture, phone }: { capture: Capture; phone: Signal<boolean> }) {
  const input = useRef<HTMLInputElement>(null);
  const take = (from: HTMLInputElement) => {
    capture.add([...(from.files ?? [])]);
    from.value = "";
  };
  return (
    <div class="in">
      <Icon name="folder" />
      <span class="grow">{t("capture.drop")}</span>
      <input
        ref={input}
        class="unseen"
        type="file"
        multiple
        accept={ACCEPTED}
        tabIndex={-1}
        aria-label={t("capture.choose")}
        id="photo-files"
        onChange={(event) => take(event.currentTarget)}
      />
      <Button onClick={() => input.current?.click()}>{t("capture.choose")}</Button>
      <Button icon="qr" pressed={phone.value} onClick={() => (phone.value = !phone.value)}>
        {t("capture.phone")}
      </Button>
    </div>
  );
}

/** Photos whose header could not be cleaned, or not all of it. */
const keptOf = ({ here }: Capture): number => here.filter((one) => one.kept.length > 0).length;

/** How many photos and bytes are here, of how many. */
function Count({ capture }: { capture: Capture }) {
  const { photos, count } = capture;
  const coming = capture.coming.onTheirWay;
  const held = photos.value.value?.bytes ?? null;
  const more = coming.reduce((sum, one) => sum + one.total - one.sent, 0);
  return (
    <div class="count">
      <h2 aria-live="polite">{coming.length ? t("capture.of", count, count + coming.length) : t("capture.here", count)}</h2>
      <span class="small faint">
        {held === null
          ? ""
          : coming.length
            ? t("capture.bytes.of", bytes(held), bytes(held + more))
            : t(keptOf(capture) ? "capture.bytes.kept" : "capture.bytes", bytes(held))}
      </span>
    </div>
  );
}

/** What was refused, what a header keeps, what waits for the network. */
function Notices({ capture }: { capture: Capture }) {
  const { openCase } = capture;
  const { onTheirWay, refused } = capture.coming;
  const kept = keptOf(capture);
  return (
    <>
      <RefusedFiles caseId={openCase.id} refused={refused} />
      {kept > 0 && (
        <Notice tone="amber" title={t("capture.kept", kept)}>
          {t("capture.kept.why")}
        </Notice>
      )}
      {onTheirWay.some((one) => one.state === "offline") && <Notice tone="amber" title={t("capture.waiting", onTheirWay.length)} />}
    </>
  );
}

/** The dial with what is missing, what the check found, and computing in spite of it. */
function Coach({ capture, few, busy }: { capture: Capture; few: string | null; busy: boolean }) {
  const { openCase, here, check, goes, askCheck, compute } = capture;
  const anyway = useSignal(false);
  const said = check.value.value;
  const answer = said?.answer ?? null;
  const computed = openCase.info.state === "finished";
  const again = t(computed ? "capture.again" : "capture.anyway");
  return (
    <aside class="pane">
      <div class="scroll" tabIndex={0} role="region" aria-label={t("dial.title")}>
        <section>
          <div class="row-head">
            <h2>{t("dial.title")}</h2>
            <span class="grow" />
            <span class="small faint">{t("dial.how")}</span>
          </div>
          <Dial data={dialOf(answer)} label={said && answer ? checkWords(said, answer).lead : t("dial.none")} />
          <p class="dial-legend small soft">
            <span>{t("dial.outer", HIGH_DEG)}</span>
            <span>{t("dial.inner")}</span>
            <b>{t("dial.missing")}</b>
          </p>
        </section>
        {answer && !goes && answer.missing.length > 0 && <HowToStand answer={answer} />}
        {answer?.coverage && <Expected coverage={answer.coverage} />}
        <Findings said={said} onCheck={capture.count >= LEAST_PHOTOS ? askCheck : null} />
      </div>
      {!goes && !busy && here.length > 0 && (
        <div class="next side-by-side">
          <p class="small faint grow">{t(computed ? "capture.again.when" : "capture.left")}</p>
          <Button off={few} onClick={() => (anyway.value = true)}>
            {again}
          </Button>
        </div>
      )}
      {anyway.value && !goes && (
        <Confirm title={t(computed ? "capture.again.sure" : "capture.anyway.sure")} yes={again} onYes={compute} onNo={() => (anyway.value = false)}>
          <p>{t(computed ? "capture.again.why" : "capture.anyway.why")}</p>
        </Confirm>
      )}
    </aside>
  );
}
