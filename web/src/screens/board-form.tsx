/** A board as it was printed: of calibration photos, or one's own beside the limb. */
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
      <BoardFields board={board.value} onChange={(part) => (board.value = { ...board.value, ...part })} />
    </>
  );
}

/** How many squares, or corners between them, and how large they are. */
export function BoardFields({ board, onChange }: { board: Board; onChange: (part: Partial<Board>) => void }) {
  const scale = board.kind === "charuco";
  const count = (name: "columns" | "rows", label: string) => (
    <NumberField label={label} unit="" step={1} decimals={0} min={2} value={board[name]} onChange={(value) => onChange({ [name]: value })} />
  );
  const length = (name: "square_mm" | "marker_mm", label: string) => (
    <NumberField label={label} unit="mm" decimals={2} min={1} value={board[name] ?? null} onChange={(value) => onChange({ [name]: value })} />
  );
  return (
    <div class="own-board">
      {count("columns", t(scale ? "board.columns" : "board.corners.across"))}
      {count("rows", t(scale ? "board.rows" : "board.corners.down"))}
      {length("square_mm", t("board.square"))}
      {scale && length("marker_mm", t("board.marker"))}
    </div>
  );
}
