/** Another side, kind or note for a case. */
import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";

import type { Schemas } from "../../api/client";
import { Button } from "../../design/parts";
import { t } from "../../texts";
import { CaseFields } from "./fields";

export function Rename({ one, onKeep, onClose }: { one: Schemas["Case"]; onKeep: (body: Schemas["CaseChange"]) => void; onClose: () => void }) {
  /** As the form was opened: what is not changed here may be changed elsewhere meanwhile. */
  const before = useMemo(() => ({ note: one.note, side: one.side ?? null, kind: one.kind ?? null }), []);
  const note = useSignal(one.note);
  const side = useSignal(one.side ?? null);
  const kind = useSignal(one.kind ?? null);
  return (
    <div class="confirm" onKeyDown={(event) => event.key === "Escape" && onClose()}>
      <CaseFields note={note} side={side} kind={kind} />
      <div class="acts">
        <Button
          go
          onClick={() =>
            onKeep({
              ...(note.value !== before.note && { note: note.value }),
              ...(side.value !== before.side && { side: side.value }),
              ...(kind.value !== before.kind && { kind: kind.value }),
            })
          }
        >
          {t("save")}
        </Button>
        <Button onClick={onClose}>{t("cancel")}</Button>
      </div>
    </div>
  );
}
