/** With what the photos are checked and computed: the camera, the board, and for experts the rest. */
import { type Schemas, answerOf, api } from "../../api/client";
import { useQuery } from "../../state/requests";
import { type Choices, PRINTED } from "../../state/choices";
import { href } from "../../state/route";
import { expert } from "../../state/settings";
import { t, when } from "../../texts";
import type { OpenCase } from "../open-case";
import { BoardSize } from "./board-size";
import { CameraSaid } from "./camera-said";
import { TapedGirth } from "./taped-girth";

export function CaptureOptions({
  openCase,
  cameras,
  choices,
  photos,
  onChange,
}: {
  openCase: OpenCase;
  photos: number;
  cameras: readonly Schemas["CameraReply"][];
  choices: Choices;
  onChange: (part: Partial<Choices>) => void;
}) {
  const ready = cameras.filter((one) => one.state === "ready" || one.calibrated);
  const chosen = ready.find((one) => choices.cameras.includes(one.id));
  const own = typeof choices.board === "object" ? choices.board : null;
  const fit = useQuery(
    async () =>
      chosen && photos > 0
        ? await answerOf(api.GET("/api/v1/cases/{case_id}/camera-fit", { params: { path: { case_id: openCase.id }, query: { camera: [chosen.id] } } }))
        : null,
    [openCase.id, chosen?.id, photos],
  );
  const set = onChange;
  return (
    <div class="options small-note">
      <label class="option">
        <span class="faint">{t("options.camera")}</span>
        <span class="field">
          <select
            aria-label={t("options.camera")}
            value={chosen?.id ?? ""}
            onChange={(event) => {
              const id = event.currentTarget.value;
              set({ cameras: id ? [id] : [] });
            }}
          >
            <option value="">{t("options.camera.none")}</option>
            {ready.map((one) => (
              <option key={one.id} value={one.id}>
                {one.name}
                {one.calibrated ? `, ${when(one.calibrated)}` : ""}
              </option>
            ))}
          </select>
        </span>
      </label>
      <label class="option">
        <span class="faint">{t("options.board")}</span>
        <span class="field">
          <select
            aria-label={t("options.board")}
            value={own ? "own" : String(choices.board)}
            onChange={(event) => {
              const value = event.currentTarget.value;
              set({
                board: value === "own" ? PRINTED : value === "none" ? "none" : "printed",
              });
            }}
          >
            <option value="printed">{t("options.board.printed")}</option>
            <option value="own">{t("options.board.own")}</option>
            <option value="none">{t("options.board.none")}</option>
          </select>
        </span>
      </label>
      <a href={href.cameras}>{t("options.calibrate")}</a>
      {chosen && <CameraSaid camera={chosen} fits={fit.value.value ?? null} />}
      <BoardSize choices={choices} onChange={onChange} />
      {choices.board !== "none" && <TapedGirth choices={choices} onChange={onChange} />}
      {choices.board === "none" && (
        <label class="check-line">
          <input type="checkbox" checked={choices.unscaled} onChange={(event) => set({ unscaled: event.currentTarget.checked })} />
          {t("options.unscaled")}
        </label>
      )}
      {expert.value && (
        <label class="check-line">
          <input type="checkbox" checked={choices.poisson} onChange={(event) => set({ poisson: event.currentTarget.checked })} />
          {t("options.poisson")}
        </label>
      )}
    </div>
  );
}
