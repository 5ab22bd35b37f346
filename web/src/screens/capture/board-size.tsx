/** How large the board is: the ruler of the printed one, or the numbers of one's own. */
import { Notice, NumberField } from "../../design/parts";
import { type Choices, RULER_MM, rulerFar, rulerOf } from "../../state/choices";
import { t } from "../../texts";
import { BoardFields } from "../board-form";

interface Props {
  readonly choices: Choices;
  readonly onChange: (part: Partial<Choices>) => void;
}

export function BoardSize({ choices, onChange }: Props) {
  const { board } = choices;
  if (board === "none") return null;
  if (board !== "printed") return <BoardFields board={board} onChange={(part) => onChange({ board: { ...board, ...part } })} />;
  const ruler_mm = rulerOf(choices);
  return (
    <div class="own-board asked">
      <NumberField label={t("options.ruler", RULER_MM)} unit="mm" value={ruler_mm} onChange={(value) => onChange({ ruler_mm: value })} />
      {rulerFar(ruler_mm) ? <Notice tone="red" title={t("options.ruler.far")} /> : <p class="soft">{t("options.ruler.how")}</p>}
    </div>
  );
}
