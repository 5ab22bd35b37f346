/** Which limb, and whose side: asked where a case does not tell. */
import type { Schemas } from "../../api/client";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { kindName, limbKinds, sided } from "../../limb-kinds";
import { perform } from "../../state/acts";
import { useAct } from "../../state/asked";
import { t } from "../../texts";
import type { RoomProps } from "../room";

export function KindAndSide({ room, onDone }: RoomProps & { onDone: () => void }) {
  const act = useAct();
  const change = (body: Schemas["CaseChange"]) =>
    act.run(async () => {
      await perform(room.id, "patch", "/api/v1/cases/{case_id}", { params: { path: { case_id: room.id } }, body });
      onDone();
    });
  return (
    <div class="asks">
      {!room.info.kind && (
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
      {!room.info.side && sided(room.info.kind) && (
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
