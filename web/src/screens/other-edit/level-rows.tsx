/** Heights, and by how many per cent the girth changes at each. */
import type { Signal } from "@preact/signals";

import { Button } from "../../design/parts";
import { t } from "../../texts";

export const FIRST_LEVELS: readonly Level[] = [
  { height: "", amount: "" },
  { height: "", amount: "" },
];

export interface Level {
  readonly height: string;
  readonly amount: string;
}

interface Props {
  readonly kind: string;
  readonly levels: Signal<readonly Level[]>;
  readonly onChange: () => void;
  readonly onKeyDown: (event: KeyboardEvent) => void;
}

export function LevelRows({ kind, levels, onChange, onKeyDown }: Props) {
  const setLevel = (number: number, part: Partial<Level>) => {
    levels.value = levels.value.map((row, i) => (i === number ? { ...row, ...part } : row));
    onChange();
  };
  return (
    <div class="level-rows" role="group" aria-label={t("other.levels")}>
      <div class="level-row small soft" aria-hidden="true">
        <span>{t("other.height")}</span>
        <span>{t(kind === "increase" ? "other.larger" : "other.smaller")}</span>
      </div>
      {levels.value.map((row, i) => (
        <div key={i} class="level-row">
          <span class="field">
            <input
              aria-label={`${t("other.height")} ${i + 1}`}
              inputMode="decimal"
              placeholder={["40", "200"][i] ?? ""}
              value={row.height}
              onInput={(event) => setLevel(i, { height: event.currentTarget.value })}
              onKeyDown={onKeyDown}
            />
            <span class="u">mm</span>
          </span>
          <span class="field">
            <input
              aria-label={`${t("other.amount")} ${i + 1}`}
              inputMode="decimal"
              placeholder={["1", "3"][i] ?? ""}
              value={row.amount}
              onInput={(event) => setLevel(i, { amount: event.currentTarget.value })}
              onKeyDown={onKeyDown}
            />
            <span class="u">%</span>
          </span>
          <Button
            bare
            icon="close"
            class="icon-only"
            label={t("other.level.off", i + 1)}
            off={levels.value.length > 1 ? null : t("other.level")}
            onClick={() => {
              levels.value = levels.value.filter((_, k) => k !== i);
              onChange();
            }}
          />
        </div>
      ))}
      <button type="button" class="linkish" onClick={() => (levels.value = [...levels.value, { height: "", amount: "" }])}>
        {t("other.level.add")}
      </button>
      <p class="small faint">{t("other.levels.between")}</p>
    </div>
  );
}
