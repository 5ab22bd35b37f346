/** The board of calibration photos, as it was printed. */
import type { Signal } from "@preact/signals";

import type { Schemas } from "../api/client";
import figures from "../api/figures.json";
import { NumberField, Segments } from "../design/parts";
import { PRINTED } from "../state/choices";
import { t } from "../texts";

type Board = Schemas["BoardSpec"];

/** The one that the program prints for calibrating a lens. */
export const CHECKERBOARD = { ...figures.LENS_BOARD, ruler: null } as Board;

export function BoardForm({ board }: { board: Signal<Board> }) {
  const set = (part: Partial<Board>) => (board.value = { ...board.value, ...part });
  return (
    <>
      <div class="setting">
        <span>{t("board.kind")}</span>
        <Segments
          label={t("board.kind")}
          value={board.value.kind}
          options={[
            { value: "checkerboard", text: t("board.checkerboard") },
            { value: "charuco", text: t("board.charuco") },
          ]}
          onChange={(kind) => (board.value = kind === "charuco" ? PRINTED : CHECKERBOARD)}
        />
      </div>
      <div class="own-board">
        <NumberField
          label={t(board.value.kind === "charuco" ? "board.columns" : "board.corners.across")}
          unit=""
          step={1}
          decimals={0}
          min={2}
          value={board.value.columns}
          onChange={(columns) => set({ columns })}
        />
        <NumberField
          label={t(board.value.kind === "charuco" ? "board.rows" : "board.corners.down")}
          unit=""
          step={1}
          decimals={0}
          min={2}
          value={board.value.rows}
          onChange={(rows) => set({ rows })}
        />
        <NumberField label={t("board.square")} unit="mm" decimals={2} min={1} value={board.value.square_mm} onChange={(square_mm) => set({ square_mm })} />
        {board.value.kind === "charuco" && (
          <NumberField label={t("board.marker")} unit="mm" decimals={2} min={1} value={board.value.marker_mm} onChange={(marker_mm) => set({ marker_mm })} />
        )}
      </div>
    </>
  );
}
