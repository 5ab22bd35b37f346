/** The picture of the written file, to be held against the patient. */
import { ROOT } from "../../api/client";
import { Button, Notice } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { exportKinds } from "../../formats";
import { go, href } from "../../state/route";
import { t } from "../../texts";
import { openWith } from "../rectify";
import { Card } from "./card";
import type { Export } from "./export";

interface Props {
  readonly made: Export;
  readonly step: number;
  readonly caseId: string;
  /** Whether the shape is open, no solid. */
  readonly shell: boolean;
}

export function PictureCard({ made, step, caseId, shell }: Props) {
  const shown = exportKinds.value.find((one) => one.kind === made.kind.value);
  const w = made.written.value;
  return (
    <Card step={step} done={made.held.value} title={t("send.picture")} aside={t("send.picture.from")}>
      {made.act.busy.value && (
        <p class="soft" role="status">
          {t("send.writing")}
        </p>
      )}
      <Refusal refused={made.act.refused.value} />
      {shown?.mesh && shell && (
        <Notice
          tone="amber"
          title={t("send.shell")}
          action={
            <Button
              onClick={() => {
                openWith.value = "wall";
                go(href.step(caseId, "rectify"));
              }}
            >
              {t("send.shell.wall")}
            </Button>
          }
        >
          {t("send.shell.why")}
        </Notice>
      )}
      {w ? (
        <>
          <img
            class="mirror"
            src={`${ROOT}/cases/${caseId}/exports/${encodeURIComponent(w.name)}/mirror?${w.sha256.slice(0, 8)}`}
            alt={t("send.picture.alt", w.side === "left" ? t("side.LEFT") : w.side === "right" ? t("side.RIGHT") : "")}
          />
          <label class={`tick ${made.held.value ? "on" : ""}`}>
            <input type="checkbox" checked={made.held.value} onChange={(event) => (made.held.value = event.currentTarget.checked)} />
            {t("send.picture.tick")}
          </label>
        </>
      ) : (
        !made.act.busy.value && <p class="soft">{t("send.picture.later")}</p>
      )}
    </Card>
  );
}
