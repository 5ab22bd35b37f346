/** Below the list: the disk, what could be cleared of it, and the sample case. */
import { useSignal } from "@preact/signals";

import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Confirm } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { bytes } from "../../numbers";
import { perform } from "../../state/acts";
import { useAct } from "../../state/requests";
import { t } from "../../texts";

export function Foot({ list, onSample, onChange }: { list: Schemas["Cases"]; onSample: () => void; onChange: () => Promise<void> }) {
  const clearing = useSignal(false);
  const act = useAct();
  const clearAll = () =>
    act.run(async () => {
      clearing.value = false;
      try {
        for (const one of list.cases.filter((case_) => case_.state !== "computing" && case_.state !== "held"))
          await perform(one.id, "post", "/api/v1/cases/{case_id}/clear", { params: { path: { case_id: one.id } } });
      } finally {
        await onChange();
      }
    });
  return (
    <>
      <Refusal refused={act.refused.value} />
      <div class="foot">
        <Icon name="disk" />
        <span>{t("cases.disk", bytes(list.bytes), list.cases.length, bytes(list.free_bytes))}</span>
        <DiskBar used={list.bytes} clearable={list.clearable_bytes} free={list.free_bytes} />
        {list.clearable_bytes > 0 && (
          <>
            <span>{t("cases.clearable", bytes(list.clearable_bytes))}</span>
            <button type="button" class="linkish" aria-expanded={clearing.value} onClick={() => (clearing.value = !clearing.value)}>
              {t("cases.see")}
            </button>
          </>
        )}
        <span class="grow" />
        {!list.cases.some((one) => one.sample) && (
          <button type="button" class="linkish" onClick={onSample}>
            {t("cases.sample")}
          </button>
        )}
      </div>
      {clearing.value && (
        <Confirm title={t("cases.clear.sure")} yes={t("cases.clear")} onYes={() => void clearAll()} onNo={() => (clearing.value = false)}>
          <p>{t("cases.clear.goes", bytes(list.clearable_bytes))}</p>
        </Confirm>
      )}
    </>
  );
}

function DiskBar({ used, clearable, free }: { used: number; clearable: number; free: number }) {
  const all = used + free || 1;
  return (
    <svg class="du" viewBox="0 0 220 8" width="220" height="8" aria-hidden="true">
      <rect class="free" width="220" height="8" />
      <rect class="kept" width={Math.max(2, (220 * (used - clearable)) / all)} height="8" />
      <rect class="clear" x={Math.max(2, (220 * (used - clearable)) / all)} width={(220 * clearable) / all} height="8" />
    </svg>
  );
}
