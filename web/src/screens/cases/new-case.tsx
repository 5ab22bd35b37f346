/** A new case: side, kind and note, then its photos. */
import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";

import type { Schemas } from "../../api/client";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { newOffer, perform } from "../../state/acts";
import { useAct } from "../../state/requests";
import { go, href } from "../../state/route";
import { t } from "../../texts";
import { CaseFields, lacksOf, sideOf } from "./fields";

type Case = Schemas["Case"];

export function NewCase({ onClose }: { onClose: () => void }) {
  const note = useSignal("");
  const side = useSignal<Case["side"] | null>(null);
  const kind = useSignal<Case["kind"] | null>(null);
  const act = useAct();
  const offer = useMemo(newOffer, []);
  const make = () =>
    act.run(async () => {
      const body = { note: note.value, side: sideOf(side.value, kind.value), kind: kind.value };
      const made = await perform("", "post", "/api/v1/cases", { body }, { id: offer.idOf(body) });
      if (act.screen.open) go(href.step(made.id, "capture"));
    });
  const lacks = act.busy.value ? t("cases.making") : lacksOf(side.value, kind.value);
  return (
    <section class="card" aria-label={t("cases.new")} onKeyDown={(event) => event.key === "Escape" && onClose()}>
      <h2>{t("cases.new")}</h2>
      <div inert={act.busy.value}>
        <CaseFields note={note} side={side} kind={kind} />
      </div>
      <Refusal refused={act.refused.value} />
      <div class="acts">
        <Button go off={lacks} onClick={() => void make()}>
          {t("cases.make")}
        </Button>
        <Button onClick={onClose}>{t("cancel")}</Button>
      </div>
    </section>
  );
}
