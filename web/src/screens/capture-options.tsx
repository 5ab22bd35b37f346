/** With what the photos are checked and computed: the camera, the board, and for experts the rest. */
import { type Schemas, api, taken } from "../api/client";
import { Chip, Notice, NumberField } from "../design/parts";
import { useAsked } from "../state/asked";
import { type Choices, RULER_MM, rulerFar, rulerOf } from "../state/choices";
import { href } from "../state/route";
import { expert } from "../state/settings";
import { t, when } from "../texts";
import type { Room } from "./room";

export function CaptureOptions({
  room,
  cameras,
  choices,
  photos,
  onChange,
}: {
  room: Room;
  photos: number;
  cameras: readonly Schemas["CameraReply"][];
  choices: Choices;
  onChange: (part: Partial<Choices>) => void;
}) {
  const ready = cameras.filter((one) => one.state === "ready" || one.calibrated);
  const chosen = ready.find((one) => choices.cameras.includes(one.id));
  const own = typeof choices.board === "object" ? choices.board : null;
  const fit = useAsked(
    async () =>
      chosen && photos > 0
        ? await taken(api.GET("/api/v1/cases/{case_id}/camera-fit", { params: { path: { case_id: room.id }, query: { camera: [chosen.id] } } }))
        : null,
    [room.id, chosen?.id, photos],
  );
  const fits = fit.value.value;
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
                board:
                  value === "own"
                    ? { kind: "charuco", columns: 7, rows: 5, square_mm: 30, marker_mm: 22, dictionary: "4X4_50", ruler: null }
                    : value === "none"
                      ? "none"
                      : "printed",
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
      {chosen && (
        <div class="camera-said">
          {chosen.age_days !== null && chosen.age_days !== undefined && (
            <Chip tone={chosen.old ? "amber" : "plain"}>{chosen.age_days ? t("cameras.age", chosen.age_days) : t("cameras.today")}</Chip>
          )}
          {fits?.fits && <Chip tone="green">{t("options.fits")}</Chip>}
          {chosen.certificate && (
            <a href={chosen.certificate} target="_blank" rel="noreferrer">
              {t("options.certificate")}
            </a>
          )}
          {chosen.old && <p class="small-note">{t("cameras.old")}</p>}
          {fits && !fits.fits && (
            <Notice tone="amber" title={t("options.fits.not")}>
              {t("options.fits.do")} {fits.why}
            </Notice>
          )}
        </div>
      )}
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
      {choices.board !== "none" && (
        <label class="check-line">
          <input
            type="checkbox"
            checked={choices.tape !== null}
            onChange={(event) => set({ tape: event.currentTarget.checked ? { height_mm: null, girth_mm: null } : null })}
          />
          {t("options.tape")}
        </label>
      )}
      {choices.board !== "none" && choices.tape && (
        <div class="own-board asked">
          <NumberField
            label={t("options.tape.height")}
            unit="mm"
            step={5}
            decimals={1}
            min={0}
            max={2000}
            value={choices.tape.height_mm}
            onChange={(value) => choices.tape && set({ tape: { ...choices.tape, height_mm: value } })}
          />
          <NumberField
            label={t("options.tape.girth")}
            unit="mm"
            step={1}
            decimals={1}
            min={1}
            max={3000}
            value={choices.tape.girth_mm}
            onChange={(value) => choices.tape && set({ tape: { ...choices.tape, girth_mm: value } })}
          />
          <p class="soft">{t("options.tape.how")}</p>
        </div>
      )}
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
