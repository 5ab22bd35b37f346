/** May the patient go? The answer in one line, and the button that computes. */
import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Button } from "../../design/parts";
import { t } from "../../texts";
import { told } from "../../words";
import { coachWords } from "../coach-words";

interface Props {
  readonly said: Schemas["Check"] | null;
  readonly info: Schemas["Case"];
  /** How many photos are here. */
  readonly photos: number;
  /** Why nothing is computed now. */
  readonly off: string | null;
  readonly onCompute: () => void;
  readonly onResult: () => void;
}

export function Banner({ said, info, photos, off, onCompute, onResult }: Props) {
  const { sample } = info;
  const done = info.state === "finished";
  const busy = isBusy(info);
  const answer = said?.answer;
  const running = said?.state === "running";
  const goes = answer?.go === true && said?.current === true;
  /** Computed, and nothing new here. */
  const rests = done && !answer && !running;
  const tone = rests ? "green" : goes ? "green" : answer && !running ? "amber" : said?.state === "refused" ? "amber" : "";
  const lead = busy
    ? t("capture.computing")
    : rests
      ? t("capture.done")
      : goes
        ? t("capture.go")
        : said?.state === "refused" && !running
          ? t("capture.cannot.check")
          : answer && !running
            ? coachWords(answer).lead
            : running
              ? t("capture.checking", said?.photos ?? 0)
              : photos
                ? t("capture.collect")
                : t(sample ? "capture.sample" : "capture.begin");
  const why = busy
    ? ""
    : rests
      ? t("capture.done.why")
      : said?.state === "refused" && !running
        ? said.finding
          ? told(said.finding)
          : ""
        : answer && !running
          ? coachWords(answer).why
          : running
            ? t("capture.checking.why")
            : t(sample && !photos ? "capture.sample.why" : "capture.begin.why");
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
        <Button go={goes || busy} off={busy ? null : off} onClick={onCompute}>
          {t(busy ? "next.watch" : "capture.compute")}
        </Button>
      )}
    </div>
  );
}

/** Whether a case is being computed, or waits for it. */
export const isBusy = ({ state }: Schemas["Case"]): boolean => state === "computing" || state === "held";
