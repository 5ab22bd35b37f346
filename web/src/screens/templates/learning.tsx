/** Which cases a template is learned from, and what it is called. */
import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";

import { type Schemas, answerOf, api } from "../../api/client";
import { Button, Chip } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { kindName } from "../../limb-kinds";
import { newOffer, perform } from "../../state/acts";
import { useAct, useQuery } from "../../state/requests";
import { t } from "../../texts";
import type { OpenCase } from "../open-case";

export function Learning({ openCase, onLearned }: { openCase: OpenCase; onLearned: (reply: Schemas["LearnedReply"]) => void }) {
  const cases = useQuery(
    async () =>
      (await answerOf(api.GET("/api/v1/cases", { params: { query: {} } }))).cases.filter((one) =>
        one.steps.some((step) => step.name === "rectify" && step.state !== "locked" && step.count > 0),
      ),
    [],
  );
  const name = useSignal("");
  const ticked = useSignal<ReadonlySet<string>>(new Set([openCase.id]));
  const act = useAct();
  const offer = useMemo(newOffer, []);
  const list = cases.value.value ?? [];
  const chosen = list.filter((one) => ticked.value.has(one.id)).map((one) => one.id);
  const learn = () =>
    act.run(async () => {
      const body = { name: name.value.trim(), cases: chosen };
      onLearned(await perform("", "post", "/api/v1/templates", { body }, { id: offer.idOf(body), lane: "learn templates" }));
    });
  return (
    <div class="learning">
      <label class="stacked" inert={act.busy.value}>
        <span>{t("template.name")}</span>
        <span class="field">
          <input maxLength={80} value={name.value} onInput={(event) => (name.value = event.currentTarget.value)} />
        </span>
      </label>
      <fieldset inert={act.busy.value}>
        <legend>{t("template.from")}</legend>
        {cases.value.value && list.length === 0 && <p class="soft small-note">{t("template.from.none")}</p>}
        {list.map((one) => (
          <label key={one.id} class="check-line">
            <input
              type="checkbox"
              checked={ticked.value.has(one.id)}
              onChange={(event) => {
                const next = new Set(ticked.value);
                if (event.currentTarget.checked) next.add(one.id);
                else next.delete(one.id);
                ticked.value = next;
              }}
            />
            {one.id} {kindName(one.kind)} {one.side === "left" || one.side === "right" ? t(`side.${one.side}`) : ""}
          </label>
        ))}
      </fieldset>
      <p class="small faint">{t(chosen.length < 5 ? "template.few" : "template.several")}</p>
      <Refusal refused={act.refused.value ?? cases.refused.value} />
      <div class="acts">
        <Button
          go
          off={act.busy.value ? t("template.busy") : !name.value.trim() ? t("template.name") : chosen.length ? null : t("template.from")}
          onClick={() => void learn()}
        >
          {t("template.learn.now", chosen.length)}
        </Button>
        {act.busy.value && <Chip tone="plain">{t("template.busy")}</Chip>}
      </div>
    </div>
  );
}
