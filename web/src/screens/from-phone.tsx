/** Photos from a phone in the same network: said here as far as the server offers it. */
import { Notice } from "../design/parts";
import { t } from "../texts";
import type { Room } from "./room";

export function FromPhone({ onClose: _close }: { room: Room; onClose: () => void }) {
  return (
    <Notice tone="plain" title={t("phone.cable")}>
      <p>{t("phone.cable.how")}</p>
      <p>{t("phone.ios")}</p>
    </Notice>
  );
}
