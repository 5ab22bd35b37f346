/** May the patient go? The answer in one line, and the button that computes. */
import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Button } from "../../design/parts";
import { t } from "../../texts";
import { bannerWords, goes, isBusy } from "./banner-words";

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
  const { lead, why, tone, icon, rests } = bannerWords(said, info, photos);
  const busy = isBusy(info);
  return (
    <div class="say" role="status">
      <span class={`mark ${tone}`}>
        <Icon name={icon} />
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
        <Button go={goes(said) || busy} off={busy ? null : off} onClick={onCompute}>
          {t(busy ? "next.watch" : "capture.compute")}
        </Button>
      )}
    </div>
  );
}
