/**
 * Compare: what is different from another shape, where, and does it matter for the fit?
 *
 * The server lays the shapes on each other, never scaled, and its one answer has the map and the
 * figures. How they were laid stands beside the figures, because it decides what they mean.
 */
import { useSignal } from "@preact/signals";
import { useMemo, useRef } from "preact/hooks";

import { decodeBlocks } from "../api/blocks";
import { ROOT, Refused, api, bytesOf, note, refusedBy, taken } from "../api/client";
import { Button, Chip, Notice, NumberField, Segments } from "../design/parts";
import { Refusal } from "../design/refusal";
import { signed, widthFor } from "../geometry/scales";
import { IDENTITY } from "../geometry/vectors";
import { kindName } from "../limb-kinds";
import { perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { shapeFiles } from "../formats";
import { expert } from "../state/settings";
import { type TextKey, bytes, t, tOr } from "../texts";
import { Stage, type Shown } from "../viewer/stage";
import type { Mode, SurfaceData } from "../viewer/surface";
import { type Finding, told } from "../words";
import { wordsOf } from "./edit-words";
import type { RoomProps } from "./room";

type Way = "auto" | "icp" | "landmarks" | "volume" | "as-is";
const WAYS: readonly Way[] = ["auto", "icp", "landmarks", "volume", "as-is"];

/** A figure of both shapes, as the server tells it. */
interface Change {
  readonly first: number;
  readonly second: number;
  readonly difference: number;
  readonly share: number | null;
  readonly sigma: number | null;
}

interface Figures {
  readonly grade: string;
  readonly verdict: Finding;
  readonly alignment: { readonly way: Way; readonly rms_mm: number | null; readonly far_limit_mm: number; readonly slide_within_mm: number | null };
  readonly radial: {
    readonly mean_radial_error_mm: number;
    readonly mean_limit_mm: number;
    readonly interquartile_range_mm: number;
    readonly range_limit_mm: number;
  } | null;
  readonly surface: { readonly on_second: { readonly p95_mm: number; readonly largest_mm: number; readonly far_mm2: number; readonly compared_share: number } };
  readonly volume: { readonly ml: Change | null; readonly sock_plies: number | null; readonly to_mm: number | null; readonly within_ml: number | null };
  readonly levels: readonly { readonly height_mm: number; readonly tape_mm?: Change | null; readonly reason: Finding | null }[];
  readonly anatomical_frame: boolean;
  readonly notes: readonly Finding[];
}

interface Compared {
  readonly surface: SurfaceData;
  readonly values: Float32Array;
  readonly figures: Figures;
}

export function CompareScreen({ room }: RoomProps) {
  const path = { params: { path: { case_id: room.id } } };
  const edited = room.info.steps.some((step) => step.name === "rectify" && step.state === "done");
  const mode = useSignal<Mode>("difference");
  const level = useSignal<number | null>(null);
  const of = useSignal<"scan" | "rectified">(edited ? "rectified" : "scan");
  /** "scan", "before NUMBER of an edit", "case ID" or "file NAME". */
  const against = useSignal(edited ? "scan" : "");
  const way = useSignal<Way>("auto");
  const spacing = useSignal(20);
  const act = useAct();
  const input = useRef<HTMLInputElement>(null);
  const others = useAsked(
    async () => (await taken(api.GET("/api/v1/cases", { params: { query: {} } }))).cases.filter((one) => one.id !== room.id && one.verdict),
    [room.id],
  );
  const recipe = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/recipe", path)), [room.id, room.news.work]);
  const files = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/shapes", path)), [room.id]);
  const found = useAsked(
    async () => (against.value ? await compared(room.id, of.value, against.value, way.value, spacing.value) : null),
    [room.id, of.value, against.value, way.value, spacing.value, room.news.work],
  );
  const one = found.value.value;
  const busy = found.busy.value;
  const shown = useMemo<Shown | null>(
    () =>
      one
        ? { surface: one.surface, frame: IDENTITY, aligned: one.figures.anatomical_frame, difference: { values: one.values, wider: widest(one.values) } }
        : null,
    [one],
  );
  const name = against.value.startsWith("case ")
    ? t("compare.case", against.value.slice(5))
    : against.value.startsWith("before ")
      ? t("compare.before", against.value.slice(7))
      : against.value.startsWith("file ")
        ? against.value.slice(5)
        : t("compare.scan");

  const send = (file: File) =>
    act.run(async () => {
      const kept = nameOf(file.name);
      const response = await fetch(`${ROOT}/cases/${room.id}/shapes/${encodeURIComponent(kept)}`, {
        method: "PUT",
        body: file,
        headers: { "Content-Type": "application/octet-stream" },
        credentials: "same-origin",
      }).catch(() => null);
      if (!response) throw new Refused("Lost", t("lost"), 0);
      note(response.status);
      if (!response.ok) throw refusedBy(response.status, await response.json().catch(() => null));
      await files.again();
      against.value = `file ${kept}`;
    });
  const forget = (file: string) =>
    act.run(async () => {
      await perform(room.id, "delete", "/api/v1/cases/{case_id}/shapes/{name}", { params: { path: { case_id: room.id, name: file } } });
      against.value = "";
      await files.again();
    });

  return (
    <div class="work">
      <Stage
        shown={shown}
        label={t("stage.compare")}
        mode={mode}
        modes={["difference", "surface"]}
        level={level}
        keys={t("compare.keys")}
        against={t("compare.against", name)}
        ends={[t("compare.smaller"), t("compare.larger")]}
        hatched={one?.values.some((v) => !Number.isFinite(v)) ? t("compare.nothing.near") : undefined}
      >
        {!one && !busy && !found.refused.value && (
          <div class="stage-note">
            <Notice tone="plain" title={t("compare.begin")}>
              {t("compare.begin.how")}
            </Notice>
          </div>
        )}
        {busy && (
          <p class="stage-wait" role="status">
            {t("compare.busy")}
          </p>
        )}
        {found.refused.value && (
          <div class="stage-note">
            <Refusal refused={found.refused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("compare")}>
        <h1 class="unseen">{t("compare")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          {one && <Answer figures={one.figures} busy={busy} />}
          {one && one.figures.notes.length > 0 && (
            <section>
              <h3>{t("compare.notes")}</h3>
              <ul class="findings small-note soft">
                {one.figures.notes.map(told).map((text) => (
                  <li key={text}>{text}</li>
                ))}
              </ul>
            </section>
          )}
          <section>
            <h2>{t("compare.with.what")}</h2>
            <label class="stacked">
              <span>{t("compare.with")}</span>
              <span class="field">
                <select value={against.value} onChange={(event) => (against.value = event.currentTarget.value)}>
                  <option value="">{t("choose")}</option>
                  {edited && of.value === "rectified" && <option value="scan">{t("compare.scan")}</option>}
                  {of.value === "rectified" &&
                    (recipe.value.value?.edits ?? []).slice(1).map((one) => (
                      <option key={one.number} value={`before ${one.number}`}>
                        {t("compare.before.edit", one.number, wordsOf(one).title)}
                      </option>
                    ))}
                  {(others.value.value ?? []).map((other) => (
                    <option key={other.id} value={`case ${other.id}`}>
                      {[other.id, kindName(other.kind), other.side === "left" || other.side === "right" ? t(`side.${other.side}`) : ""]
                        .filter(Boolean)
                        .join(", ")}
                    </option>
                  ))}
                  {(files.value.value ?? []).map((file) => (
                    <option key={file.name} value={`file ${file.name}`}>
                      {file.name} ({bytes(file.bytes)})
                    </option>
                  ))}
                </select>
              </span>
            </label>
            <input
              ref={input}
              class="unseen"
              type="file"
              tabIndex={-1}
              accept={shapeFiles.value.join(",")}
              id="shape-file"
              aria-label={t("compare.file")}
              onChange={(event) => {
                const file = event.currentTarget.files?.[0];
                if (file) void send(file);
                event.currentTarget.value = "";
              }}
            />
            <div class="acts">
              <Button icon="folder" off={act.busy.value && t("loading")} onClick={() => input.current?.click()}>
                {t("compare.file")}
              </Button>
              {against.value.startsWith("file ") && <Button onClick={() => void forget(against.value.slice(5))}>{t("compare.forget")}</Button>}
            </div>
            <p class="small faint">{t("compare.file.how")}</p>
            <Refusal refused={act.refused.value ?? others.refused.value ?? recipe.refused.value ?? files.refused.value} />
          </section>
          <section>
            {edited && (
              <div class="setting">
                <span>{t("compare.this")}</span>
                <Segments
                  label={t("compare.this")}
                  value={of.value}
                  options={[
                    { value: "scan", text: t("measure.of.scan") },
                    { value: "rectified", text: t("measure.of.rectified") },
                  ]}
                  onChange={(value) => {
                    of.value = value;
                    if (value === "scan" && /^(scan|before )/.test(against.value)) against.value = "";
                  }}
                />
              </div>
            )}
            <label class="stacked">
              <span>{t("compare.laid")}</span>
              <span class="field">
                <select value={way.value} onChange={(event) => (way.value = event.currentTarget.value as Way)}>
                  {WAYS.map((value) => (
                    <option key={value} value={value}>
                      {t(`compare.way.${value}`)}
                    </option>
                  ))}
                </select>
              </span>
              <span class="small faint">{t(`compare.way.how.${way.value}`)}</span>
            </label>
            <NumberField
              label={t("measure.spacing")}
              unit="mm"
              step={5}
              decimals={1}
              min={1}
              max={200}
              value={spacing.value}
              onChange={(value) => (spacing.value = value)}
            />
          </section>
          {one && <Levels figures={one.figures} level={level.value} onLevel={(h) => (level.value = h)} />}
          {expert.value && one && <section class="mono">{told(one.figures.verdict)}</section>}
        </div>
        <div class="next">
          <Button go big trailing="next" onClick={() => go(href.step(room.id, edited ? "send" : "rectify"))}>
            {t(edited ? "rectify.next" : "measure.next")}
          </Button>
        </div>
      </aside>
    </div>
  );
}

/** What the difference means for the fit, its figures, and how the shapes were laid on each other. */
function Answer({ figures, busy }: { figures: Figures; busy: boolean }) {
  const { radial, volume, surface, alignment } = figures;
  const far = alignment.rms_mm !== null && alignment.rms_mm > alignment.far_limit_mm;
  const tone = figures.grade === "alike" ? "green" : figures.grade === "not graded" ? "plain" : "amber";
  const ml = volume.ml;
  return (
    <section class={busy ? "waits" : ""}>
      <div class="verdict">
        <Chip tone={tone}>{tOr(`grade.${figures.grade}`, figures.grade)}</Chip>
        <p class="lead-line">
          {ml
            ? t(
                ml.difference < 0 ? "compare.less" : "compare.more",
                Math.abs(ml.difference).toFixed(1),
                volume.within_ml === null ? "" : ` ± ${volume.within_ml.toFixed(1)}`,
                (100 * Math.abs(ml.share ?? 0)).toFixed(1),
              )
            : t("compare.no.volume")}
        </p>
      </div>
      <div class="fig">
        <div>
          <h3>{t("compare.size")}</h3>
          <b>{radial ? `${signed(radial.mean_radial_error_mm, 2)} mm` : "–"}</b>
          <span class="small faint">{radial ? t("compare.limit", radial.mean_limit_mm.toFixed(2)) : ""}</span>
        </div>
        <div>
          <h3>{t("compare.shape")}</h3>
          <b>{radial ? `${radial.interquartile_range_mm.toFixed(2)} mm` : "–"}</b>
          <span class="small faint">{radial ? t("compare.limit", radial.range_limit_mm.toFixed(2)) : ""}</span>
        </div>
        <div>
          <h3>{t("compare.within")}</h3>
          <b>{surface.on_second.p95_mm.toFixed(2)} mm</b>
          <span class="small faint">{t("compare.largest", surface.on_second.largest_mm.toFixed(1))}</span>
        </div>
      </div>
      <p class="soft small-note" role="status">
        {t(`compare.laid.${alignment.way}` as TextKey)}
        {alignment.rms_mm !== null && ` ${t("compare.apart", alignment.rms_mm.toFixed(2))}`}
        {alignment.slide_within_mm !== null && ` ${t("compare.slide", alignment.slide_within_mm.toFixed(1))}`}
        {` ${t("compare.share", (100 * surface.on_second.compared_share).toFixed(0))}`}
      </p>
      {far && (
        <Notice tone="amber" title={t("compare.far")}>
          {t("compare.far.do")}
        </Notice>
      )}
    </section>
  );
}

function Levels({ figures, level, onLevel }: { figures: Figures; level: number | null; onLevel: (height_mm: number) => void }) {
  return (
    <section class="tab">
      <table>
        <thead>
          <tr>
            <th class="num">{t("th.height")}</th>
            <th class="num">{t("compare.th.first")}</th>
            <th class="num">{t("compare.th.second")}</th>
            <th class="num">{t("th.change")}</th>
          </tr>
        </thead>
        <tbody>
          {[...figures.levels].reverse().map((one) => {
            const girth = one.tape_mm ?? null;
            const on = level !== null && Math.abs(level - one.height_mm) < 8;
            return (
              <tr
                key={one.height_mm}
                class={`pick ${on ? "on" : ""}`}
                tabIndex={0}
                aria-current={on || undefined}
                title={one.reason ? told(one.reason) : undefined}
                onClick={() => onLevel(one.height_mm)}
                onFocus={() => onLevel(one.height_mm)}
              >
                <td class="num">{one.height_mm.toFixed(0)}</td>
                <td class="num soft">{girth?.first.toFixed(1) ?? "–"}</td>
                <td class="num">{girth?.second.toFixed(1) ?? "–"}</td>
                <td class={`num ${girth && girth.difference < -0.05 ? "neg" : girth && girth.difference > 0.05 ? "pos" : ""}`}>
                  {girth ? signed(girth.difference) : "–"}
                </td>
              </tr>
            );
          })}
        </tbody>
      </table>
      <p class="small faint">{t("compare.girths")}</p>
    </section>
  );
}

async function compared(id: string, of: "scan" | "rectified", against: string, align: Way, spacing_mm: number): Promise<Compared> {
  const what = against.startsWith("case ")
    ? { case: against.slice(5) }
    : against.startsWith("file ")
      ? { shape: against.slice(5) }
      : against.startsWith("before ")
        ? { edits: Number(against.slice(7)) - 1 }
        : {};
  const { bytes: answer } = await bytesOf(`/cases/${encodeURIComponent(id)}/compare/differences`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ of, align, spacing_mm, ...what }),
  });
  const { header, blocks } = decodeBlocks(answer);
  const [positions, indices, values] = [blocks.get("positions"), blocks.get("indices"), blocks.get("signed_mm")];
  const surface: SurfaceData = {
    positions: positions instanceof Float32Array ? positions : new Float32Array(),
    indices: indices instanceof Uint32Array ? indices : new Uint32Array(),
    sigma: null,
    colours: null,
    filled: null,
  };
  return { surface, values: values instanceof Float32Array ? values : new Float32Array(), figures: header.figures as Figures };
}

/** The factor of the bands by what all but a hundredth of the surface keeps: one stray corner is no scale. */
function widest(values: Float32Array): number {
  const sizes = values
    .filter((v) => Number.isFinite(v))
    .map(Math.abs)
    .sort();
  return widthFor(sizes.length ? sizes[Math.floor(0.99 * (sizes.length - 1))] : 0);
}

/** A name that the server takes: letters, digits and a known ending. */
export function nameOf(file: string): string {
  const dot = file.lastIndexOf(".");
  const stem = (dot < 0 ? file : file.slice(0, dot))
    .normalize("NFKD")
    .replace(/[^A-Za-z0-9 _-]+/g, "-")
    .replace(/^[^A-Za-z0-9]+/, "")
    .slice(0, 60);
  return `${stem || "shape"}.${dot < 0 ? "" : file.slice(dot + 1).toLowerCase()}`;
}
