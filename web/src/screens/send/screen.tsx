/**
 * Send: right side, right file? The file is written and read back by the server; two checks are made
 * by a person: the side, asked without a guess, and the picture against the patient.
 */
import { ROOT, answerOf, api } from "../../api/client";
import { Button } from "../../design/parts";
import { useQuery } from "../../state/requests";
import { go, href } from "../../state/route";
import { t } from "../../texts";
import type { CaseProps } from "../open-case";
import { Earlier } from "./earlier";
import { useExport } from "./export";
import { KindCard } from "./kind-card";
import { PictureCard } from "./picture-card";
import { Readback } from "./readback";
import { SideCard } from "./side-card";
import { SignerCard } from "./signer-card";

export function SendScreen({ openCase }: CaseProps) {
  const path = { params: { path: { case_id: openCase.id } } };
  const ledger = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/recipe/ledger", path)), [openCase.id, openCase.changes.work]);
  const made = useExport(openCase, ledger.value.value?.recipe.tag ?? null);
  const w = made.written.value;
  const off = made.off();
  return (
    <div class="work">
      <main class="send-main" id="content" tabIndex={-1}>
        <div>
          <h1>{t("step.send")}</h1>
          <p class="soft">{t("send.how")}</p>
        </div>
        <KindCard made={made} />
        {!made.torso && <SideCard made={made} step={2} />}
        {made.red && <SignerCard made={made} step={made.torso ? 2 : 3} />}
        <PictureCard made={made} step={2 + Number(!made.torso) + Number(made.red)} caseId={openCase.id} shell={ledger.value.value?.solid === false} />
      </main>
      <aside class="pane" aria-label={t("send.file")}>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <Readback w={w} />
          <Earlier files={made.before.value.value ?? []} />
        </div>
        <div class="next">
          {off || !w ? (
            <Button go big off={off ?? t("send.off.none")}>
              {t("send.save")}
            </Button>
          ) : (
            <a class="btn go big" id="save-file" href={`${ROOT}/cases/${openCase.id}/exports/${encodeURIComponent(w.name)}`} download={w.name}>
              {t("send.save")}
            </a>
          )}
          <p class="small soft">
            {off ?? (
              <button type="button" class="linkish" onClick={() => go(href.step(openCase.id, "record"))}>
                {t("send.next")}
              </button>
            )}
          </p>
        </div>
      </aside>
    </div>
  );
}
