/** Which limb, and whose side: asked where a case does not tell. */
import type { Schemas } from "../../api/client";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { kindName, limbKinds, sided } from "../../limb-kinds";
import { perform } from "../../state/acts";
import { useAct } from "../../state/requests";
import { t } from "../../texts";
import type { CaseProps } from "../open-case";

export function KindAndSide({ openCase, onDone }: CaseProps & { onDone: () => void }) {
  const act = useAct();
  const change = (body: Schemas["CaseChange"]) =>
    act.run(async () => {
      await perform(openCase.id, "patch", "/api/v1/cases/{case_id}", { params: { path: { case_id: openCase.id } }, body });
      onDone();
    });
  return (
    <div class="asks">
      {!openCase.info.kind && (
        <>
          <h3>{t("cases.which.kind")}</h3>
          <div class="choices">
            {limbKinds.value.map((one) => (
              <Button key={one.kind} onClick={() => void change({ kind: one.kind })}>
                {kindName(one.kind)}
              </Button>
            ))}
          </div>
        </>
      )}
      {!openCase.info.side && sided(openCase.info.kind) && (
        <>
          <h3>{t("cases.which.side")}</h3>
          <div class="choices">
            {(["right", "left"] as const).map((one) => (
              <Button key={one} onClick={() => void change({ side: one })}>
                {t(`side.${one}`)}
              </Button>
            ))}
          </div>
        </>
      )}
      <Refusal refused={act.refused.value} />
    </div>
  );
}
