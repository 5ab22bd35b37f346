/** Cases: which limb, what next. The list, the new case, the archive, the disk. */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";

import { answerOf, api } from "../../api/client";
import { listen } from "../../api/events";
import { Icon } from "../../design/icons";
import { Button, Empty, Notice } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { perform } from "../../state/acts";
import { useAct, useQuery } from "../../state/requests";
import { go, href } from "../../state/route";
import { t } from "../../texts";
import { FILTERS, type Filter, membersOf } from "./filters";
import { Foot } from "./foot";
import { NewCase } from "./new-case";
import { CasesTable } from "./table";

export function CasesScreen() {
  const asked = useQuery(() => answerOf(api.GET("/api/v1/cases", {})), []);
  const filter = useSignal<Filter>("all");
  const find = useSignal("");
  const making = useSignal(false);
  const act = useAct();
  useEffect(() => listen("/events", () => void asked.again()), []);

  const list = asked.value.value;
  const all = list?.cases ?? [];
  const members = membersOf(all);
  const wanted = find.value.trim().toLowerCase();
  const shown = members[filter.value].filter((one) => `${one.id} ${one.note}`.toLowerCase().includes(wanted));

  const sample = () =>
    act.run(async () => {
      const made = await perform("", "post", "/api/v1/cases/sample", {});
      go(href.step(made.id, "capture"));
    });

  return (
    <main class="cases" id="content" tabIndex={-1}>
      <div class="head">
        <h1>{t("cases")}</h1>
        <div class="filters" role="radiogroup" aria-label={t("cases")}>
          {FILTERS.map((one) => (
            <button
              key={one}
              type="button"
              role="radio"
              aria-checked={filter.value === one}
              class={filter.value === one ? "on" : ""}
              onClick={() => (filter.value = one)}
            >
              {t(`cases.${one}`, members[one].length)}
            </button>
          ))}
        </div>
        <span class="grow" />
        <label class="field find">
          <Icon name="find" />
          <span class="unseen">{t("cases.find")}</span>
          <input type="search" placeholder={t("cases.find")} value={find.value} onInput={(event) => (find.value = event.currentTarget.value)} />
        </label>
        <Button go icon="plus" onClick={() => (making.value = !making.value)}>
          {t("cases.new")}
        </Button>
      </div>
      {making.value && <NewCase onClose={() => (making.value = false)} />}
      <Refusal refused={asked.refused.value ?? act.refused.value} action={<Button onClick={() => void asked.again()}>{t("again")}</Button>} />
      {act.busy.value && !making.value && <Notice tone="plain" title={t("cases.sample.making")} />}
      {list && all.length === 0 && !making.value && (
        <Empty icon="limb" title={t("cases.empty")}>
          <p>{t("cases.empty.how")}</p>
          <div class="acts">
            <Button icon="plus" onClick={() => (making.value = true)}>
              {t("cases.new")}
            </Button>
            <Button off={act.busy.value && t("cases.sample.making")} onClick={() => void sample()}>
              {t("cases.sample")}
            </Button>
          </div>
        </Empty>
      )}
      {list && all.length > 0 && shown.length === 0 && (
        <Empty icon="find" title={wanted ? t("cases.none", find.value) : t("cases.none.here")}>
          <div class="acts">
            <Button
              onClick={() => {
                find.value = "";
                filter.value = "all";
              }}
            >
              {t("cases.all.show")}
            </Button>
          </div>
        </Empty>
      )}
      {shown.length > 0 && <CasesTable shown={shown} onChange={() => void asked.again()} />}
      {list && all.length > 0 && <Foot list={list} onSample={() => void sample()} onChange={asked.again} />}
    </main>
  );
}
