/** Below a case in the list: why an act was refused, and what is asked before one is done. */
import type { Schemas } from "../../api/client";
import { Confirm } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { bytes } from "../../numbers";
import { t, tOr } from "../../texts";
import type { ActsOfCase } from "./acts-of-case";
import { Rename } from "./rename";

export function AskedFirst({ one, acts }: { one: Schemas["Case"]; acts: ActsOfCase }) {
  const { doing, held } = acts;
  const close = () => (doing.value = null);
  const bytesOf = (parts: readonly Schemas["Held"][]) => parts.reduce((sum, part) => sum + part.bytes, 0);
  return (
    <>
      <Refusal refused={acts.refused.value} />
      {doing.value === "delete" && (
        <Confirm danger title={t("cases.delete.sure", one.id)} yes={t("cases.delete")} onYes={() => void acts.remove()} onNo={close}>
          <p>
            {t(
              "cases.delete.goes",
              held.value.reduce((n, part) => n + part.files, 0),
              bytes(bytesOf(held.value)),
            )}
          </p>
          <ul class="held">
            {held.value.map((part) => (
              <li key={part.what}>
                {tOr(`held.${part.what}`, part.what)}: {part.files}, {bytes(part.bytes)}
              </li>
            ))}
          </ul>
        </Confirm>
      )}
      {doing.value === "clear" && (
        <Confirm title={t("cases.clear.sure")} yes={t("cases.clear")} onYes={() => void acts.clear()} onNo={close}>
          <p>{t("cases.clear.goes", bytes(bytesOf(held.value.filter((part) => part.what === "intermediate products"))))}</p>
        </Confirm>
      )}
      {doing.value === "rename" && <Rename one={one} onKeep={(body) => void acts.change(body)} onClose={close} />}
    </>
  );
}
