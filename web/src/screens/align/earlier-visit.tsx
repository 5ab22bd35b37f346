/** The choice of an earlier visit, and why some of its places are not proposed. */
import { Notice } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { t } from "../../texts";
import { term, told } from "../../words";
import type { Visit } from "./visit";

export function EarlierVisit({ visit }: { readonly visit: Visit }) {
  const { cases, chosen, asked } = visit;
  if (!cases.length) return null;
  const left = asked.value.value?.left_out ?? [];
  return (
    <section>
      <label class="stacked">
        <span>{t("align.visit")}</span>
        <span class="field">
          <select value={chosen.value} onChange={(event) => (chosen.value = event.currentTarget.value)}>
            <option value="">{t("align.visit.none")}</option>
            {cases.map(({ id, made }) => (
              <option key={id} value={id}>
                {`${id}, ${made.slice(0, 10)}`}
              </option>
            ))}
          </select>
        </span>
      </label>
      <p class="small faint" role="status">
        {asked.busy.value && chosen.value ? t("loading") : t("align.visit.how")}
      </p>
      {left.length > 0 && (
        <Notice tone="plain" title={t("align.visit.left")}>
          {left.map((one) => (
            <p key={one.name}>{`${term(one.name)}: ${told(one.reason)}`}</p>
          ))}
        </Notice>
      )}
      <Refusal refused={asked.refused.value} />
    </section>
  );
}
