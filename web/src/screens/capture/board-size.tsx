/** How large the board is: the ruler of the printed one, or the numbers of one's own. */
import { Notice, NumberField } from "../../design/parts";
import { type Choices, RULER_MM, rulerFar, rulerOf } from "../../state/choices";
import { t } from "../../texts";

interface Props {
  readonly choices: Choices;
  readonly onChange: (part: Partial<Choices>) => void;
}

export function BoardSize({ choices, onChange: set }: Props) {
  const own = typeof choices.board === "object" ? choices.board : null;
  return (
    <>
      {choices.board === "printed" && (
        <div class="own-board asked">
          <NumberField
            label={t("options.ruler", RULER_MM)}
            unit="mm"
            step={0.1}
            decimals={1}
            value={rulerOf(choices)}
            onChange={(value) => set({ ruler_mm: value })}
          />
          {rulerFar(rulerOf(choices)) ? <Notice tone="red" title={t("options.ruler.far")} /> : <p class="soft">{t("options.ruler.how")}</p>}
        </div>
      )}
      {own && (
        <div class="own-board">
          {(
            [
              ["columns", t("board.columns"), "", 1, 0],
              ["rows", t("board.rows"), "", 1, 0],
              ["square_mm", t("board.square"), "mm", 0.1, 2],
              ["marker_mm", t("board.marker"), "mm", 0.1, 2],
            ] as const
          ).map(([name, label, unit, step, decimals]) => (
            <NumberField
              key={name}
              label={label}
              unit={unit}
              step={step}
              decimals={decimals}
              min={1}
              value={own[name] ?? null}
              onChange={(value) => set({ board: { ...own, [name]: value } })}
            />
          ))}
        </div>
      )}
    </>
  );
}
