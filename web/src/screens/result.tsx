/**
 * Result: can I trust it, and where not? While it is computed: how far, how long, and what is there.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { Vector3 } from "three";

import { type Schemas, api, taken } from "../api/client";
import { Icon } from "../design/icons";
import { Button, Chip, Notice } from "../design/parts";
import { Refusal, parted } from "../design/refusal";
import { type Vec3, apply, cross, sub, unit } from "../geometry/vectors";
import { cut, heightsOf } from "../geometry/section";
import { perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { expert } from "../state/settings";
import { t } from "../texts";
import { type Finding, advice, isFinding, same, sentence, told } from "../words";
import { Stage, type Shown } from "../viewer/stage";
import type { Mode, SurfaceData } from "../viewer/surface";
import type { Viewer } from "../viewer/viewer";
import { withoutColour } from "./cases";
import { Computing } from "./computing";
import { type Limb, useLimb } from "./limb";
import { PointCard } from "./point-card";
import type { RoomProps } from "./room";

export function ResultScreen({ room }: RoomProps) {
  const working = ["computing", "held", "interrupted", "cancelled", "refused", "failed"].includes(room.info.state);
  const shape = room.info.steps.some((step) => step.name === "align" && step.state !== "locked");
  const stay = useSignal(false);
  useEffect(() => {
    stay.value = false;
  }, [room.info.state]);
  if ((working && !stay.value) || !shape) return <Computing room={room} onLook={shape ? () => (stay.value = true) : null} />;
  return <Finished room={room} />;
}

export interface GirthRow {
  readonly height_mm: number;
  readonly girth: number | null;
  readonly within: number | null;
  readonly area_cm2: number | null;
  readonly below_ml: number | null;
  /** Measured by the server; else by this page, from the guessed axis. */
  readonly kept: boolean;
}

function Finished({ room }: RoomProps) {
  const { limb, asked } = useLimb(room, "scan");
  const mode = useSignal<Mode>("sure");
  const level = useSignal<number | null>(null);
  const picked = useSignal<Vec3 | null>(null);
  const act = useAct();
  const viewer = useRef<Viewer | null>(null);
  const path = { params: { path: { case_id: room.id } } };
  const aligned = limb?.reply.aligned ?? false;
  const measures = useAsked(
    async () => (aligned ? await taken(api.POST("/api/v1/cases/{case_id}/measures", { ...path, body: { of: "scan", spacing_mm: 20, volumes: [], lengths: [], tapes: [], inside: false, unaligned: false, sheet: false, shoe_heel_mm: 0, shoe_sole_mm: 0, with_tape: false } })) : null),
    [room.id, aligned, limb?.reply.sha256],
  );
  const kit = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/kit", path)), [room.id, room.info.state]);
  const rows = useMemo(() => rowsOf(limb, measures.value.value), [limb, measures.value.value]);
  const shown = useMemo<Shown | null>(() => (limb ? { surface: limb.fetched.data, frame: limb.frame, aligned: limb.reply.aligned } : null), [limb]);
  useEffect(() => {
    if (level.value === null && rows.length) level.value = rows[Math.min(4, rows.length - 1)].height_mm;
  }, [rows]);
  const measured = useMemo(() => (limb ? share(limb.fetched.data) : null), [limb]);
  const refresh = () =>
    act.run(async () => {
      await perform(room.id, "post", "/api/v1/cases/{case_id}/limb/refresh", path);
      await asked.again();
    });
  return (
    <div class="work">
      <Stage
        shown={shown}
        label={t("stage.limb")}
        mode={mode}
        modes={["surface", "photo", "sure"]}
        level={level}
        keys={t("result.keys")}
        onReady={(made) => (viewer.current = made)}
        onClick={(hit) => (picked.value = hit && at(hit.point))}
        marks={limb ? picks(picked.value) : []}
      >
        {picked.value && limb && <PointCard room={room} point={picked.value} onClose={() => (picked.value = null)} />}
        {asked.refused.value && (
          <div class="stage-note">
            <Refusal refused={asked.refused.value} action={<Button onClick={() => void asked.again()}>{t("again")}</Button>} />
          </div>
        )}
        {!limb && !asked.refused.value && <p class="stage-wait">{t("stage.loading")}</p>}
      </Stage>
      <aside class="pane" aria-label={t("step.result")}>
        <h1 class="unseen">{t("step.result")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <VerdictLines info={room.info} />
            <SizeLines tapes={kit.value.value?.tapes ?? []} verdict={room.info.verdict} />
            {measured && limb && (
              <div class="fig">
                <div>
                  <h3>{t("fig.measured")}</h3>
                  <b>{(100 * measured.share).toFixed(measured.share > 0.9995 ? 0 : 1)} %</b>
                  <span class="small faint">{measured.share > 0.9995 ? t("fig.nothing.filled") : t("fig.filled", (100 - 100 * measured.share).toFixed(1))}</span>
                </div>
                <div>
                  <h3>{t("fig.sure")}</h3>
                  <b>± {measured.typical.toFixed(2)} mm</b>
                  <span class="small faint">{t("fig.sure.half")}</span>
                </div>
                <div>
                  <h3>{t("fig.photos")}</h3>
                  <b>{room.info.photos}</b>
                  <span class="small faint">{t("fig.photos.sent")}</span>
                </div>
              </div>
            )}
            {measured && limb && measured.worst_mm > 0 && (
              <div class="todo">
                <Icon name="eye" />
                <span>
                  {t("result.least", measured.worst_mm.toFixed(1), Math.max(0, apply(limb.frame, measured.where)[2]).toFixed(0))}{" "}
                  <button type="button" class="linkish" onClick={() => {
                      picked.value = measured.where;
                      viewer.current?.lookAt(new Vector3(...measured.where), new Vector3(...measured.normal));
                    }}>
                    {t("result.show")}
                  </button>
                </span>
              </div>
            )}
            {limb?.reply.stale && (
              <Notice tone="amber" title={t("result.stale")} action={<Button onClick={() => void refresh()}>{t("result.take")}</Button>}>
                {t("result.stale.why")}
              </Notice>
            )}
            <Refusal refused={act.refused.value ?? measures.refused.value} />
          </section>
          <section class="tab">
            <GirthTable rows={rows} level={level.value} onLevel={(h) => (level.value = h)} />
          </section>
          {kit.value.value && <KitLines kit={kit.value.value} />}
          <NoteLines notes={kit.value.value?.notes ?? []} verdict={room.info.verdict} />
          <section class="small-note">
            <a href={href.step(room.id, "compare")}>{t("result.compare")}</a>
          </section>
          <section class="small faint">{t(aligned ? "result.heights" : "result.heights.guess")}</section>
          {expert.value && limb && (
            <section class="mono">
              {limb.reply.vertices} {t("expert.vertices")}, {limb.reply.faces} {t("expert.triangles")}
              <br />
              sha256 {limb.reply.sha256.slice(0, 16)}…<br />
              <a href={`/api/v1/cases/${room.id}/report`} target="_blank" rel="noreferrer">
                {t("expert.report")}
              </a>
            </section>
          )}
        </div>
        <div class="next">
          <Button go big trailing="next" onClick={() => go(href.step(room.id, aligned ? "measure" : "align"))}>
            {aligned ? t("result.next.measure") : t("result.next")}
          </Button>
          {!aligned && <p class="small faint">{t("result.guess")}</p>}
        </div>
      </aside>
    </div>
  );
}

export const at = (p: Vector3): Vec3 => [p.x, p.y, p.z];

function picks(point: Vec3 | null) {
  return point ? [{ name: "·", label: "", point: new Vector3(...point), state: "chosen" as const }] : [];
}

export function VerdictLines({ info }: { info: Schemas["Case"] }) {
  const verdict = info.verdict;
  if (!verdict) return <p class="lead-line">{info.finding ? told(info.finding) : t("result.none")}</p>;
  const [lead, more] = parted(told(withoutColour(verdict.headline)));
  const said = toldIn(verdict.headline);
  const reasons = said.length ? unsaid(verdict.reasons.slice(0, expert.value ? 20 : 2), said) : [];
  return (
    <>
      <div class="verdict">
        <Chip tone={verdict.light}>{t(`verdict.${verdict.light}`)}</Chip>
        <p class="lead-line">{lead}</p>
      </div>
      {more && <p class="small-note soft">{more}</p>}
      {verdict.light !== "green" && reasons.length > 0 && (
        <ul class="findings small-note soft">
          {reasons.map((one) => (
            <li key={one.code}>{told(one)}</li>
          ))}
        </ul>
      )}
    </>
  );
}

/** What a tape said of the size, where the verdict above does not say it; or how to have it checked where nothing did. */
function SizeLines({ tapes, verdict }: { tapes: Schemas["Kit"]["tapes"]; verdict: Schemas["Case"]["verdict"] }) {
  const said = saidOf(verdict);
  if (!tapes.length)
    return verdict && !verdict.size_checked && verdict.light !== "red" ? (
      <Notice tone="amber" title={t("size.unchecked")}>
        {t("size.unchecked.do")}
      </Notice>
    ) : null;
  return (
    <div class="chk said" role="group" aria-label={t("size.tape")}>
      {tapes.filter((one) => unsaid([one.finding], said).length).map((one) => (
        <div key={told(one.finding)}>
          <Icon name={one.light === "green" ? "ok" : "warn"} tone={one.light === "green" ? "g" : "a"} />
          {told(one.finding)}
        </div>
      ))}
    </div>
  );
}

/** The camera that took the photos, and the certificate of the kit with its age. */
function KitLines({ kit }: { kit: Schemas["Kit"] }) {
  return (
    <section class="small-note">
      <p class="soft">{kit.cameras.length ? t("kit.camera", kit.cameras.filter(Boolean).join(", ") || t("kit.camera.unnamed")) : t("kit.none")}</p>
      {kit.setups.map((one) =>
        one.due ? (
          <Notice key={one.camera + one.made} tone="amber" title={sentence(one.finding)}>
            {advice(one.finding)}
          </Notice>
        ) : (
          <p key={one.camera + one.made} class="soft">
            {told(one.finding)}
          </p>
        ),
      )}
    </section>
  );
}

/** Whether the limb kept still and what was done with the photos, where the verdict above does not say it. */
function NoteLines({ notes, verdict }: { notes: Schemas["Kit"]["notes"]; verdict: Schemas["Case"]["verdict"] }) {
  const said = saidOf(verdict);
  const more = unsaid(notes, said);
  if (!more.length) return null;
  return (
    <section class="small-note" role="group" aria-label={t("result.notes")}>
      <h3>{t("result.notes")}</h3>
      {more.map((one) => (
        <p key={told(one)} class="soft">
          {told(one)}
        </p>
      ))}
    </section>
  );
}

/** What the lines of the verdict say to everybody. */
function saidOf(verdict: Schemas["Case"]["verdict"]): Finding[] {
  return verdict ? [...toldIn(verdict.headline), ...verdict.reasons.slice(0, 2)] : [];
}

/** What a headline tells, finding by finding; nothing of a file of an earlier version, which has it in one sentence. */
const toldIn = (headline: Finding): Finding[] => Object.values(withoutColour(headline).values).filter(isFinding);

const unsaid = (found: readonly Finding[], said: readonly Finding[]): Finding[] => found.filter((one) => !said.some((other) => same(one, other)));

interface Share {
  share: number;
  /** Two sigma that half of the surface keeps, mm. */
  typical: number;
  worst_mm: number;
  where: Vec3;
  normal: Vec3;
}

/** How much was measured, how sure the half of it is, and where it is least sure over some breadth. */
function share(data: SurfaceData): Share | null {
  if (!data.sigma) return null;
  const count = data.sigma.length;
  let filled = 0;
  const kept: number[] = [];
  for (let i = 0; i < count; i++) {
    if (data.filled?.[i] || !Number.isFinite(data.sigma[i])) filled++;
    else kept.push(data.sigma[i]);
  }
  if (!kept.length) return null;
  kept.sort((a, b) => a - b);
  // Single corners are no doubt to act on: the mean over each triangle's corners, the 99.8th of a hundred.
  const limit = kept[Math.floor(0.998 * (kept.length - 1))];
  let place = -1;
  let face = -1;
  let worst = 0;
  for (let f = 0; f < data.indices.length; f += 3) {
    const [a, b, c] = [data.indices[f], data.indices[f + 1], data.indices[f + 2]];
    const low = Math.min(data.sigma[a], data.sigma[b], data.sigma[c]);
    if (Number.isFinite(low) && low > worst && low <= 4 * limit) [worst, place, face] = [low, a, f];
  }
  const p: Vec3 = place < 0 ? [0, 0, 0] : [data.positions[3 * place], data.positions[3 * place + 1], data.positions[3 * place + 2]];
  return {
    share: 1 - filled / count,
    typical: 2 * kept[Math.floor(kept.length / 2)],
    worst_mm: 2 * worst,
    where: p,
    normal: face < 0 ? [0, 0, 1] : normalOf(data, face),
  };
}

function normalOf(data: SurfaceData, f: number): Vec3 {
  const corner = (k: number): Vec3 => {
    const i = 3 * data.indices[f + k];
    return [data.positions[i], data.positions[i + 1], data.positions[i + 2]];
  };
  return unit(cross(sub(corner(1), corner(0)), sub(corner(2), corner(0))));
}

function rowsOf(limb: Limb | null, measures: Schemas["MeasuresReply"] | null): GirthRow[] {
  if (!limb) return [];
  if (measures)
    return measures.levels
      .map((one) => ({
        height_mm: one.height_mm,
        girth: one.tape_mm?.value ?? null,
        within: one.tape_mm?.within ?? null,
        area_cm2: one.area_mm2 ? one.area_mm2.value / 100 : null,
        below_ml: one.volume_below_ml?.value ?? null,
        kept: true,
      }))
      .reverse();
  const { positions, indices } = limb.fetched.data;
  const heights = heightsOf(positions, limb.frame);
  let top = 0;
  for (const h of heights) top = Math.max(top, h);
  const rows: GirthRow[] = [];
  for (let h = 20; h < top - 4; h += 20) {
    const section = cut(positions, indices, heights, h, limb.frame);
    rows.push({
      height_mm: h,
      girth: Number.isFinite(section.tape_mm) ? section.tape_mm : null,
      within: null,
      area_cm2: Number.isFinite(section.area_mm2) ? section.area_mm2 / 100 : null,
      below_ml: null,
      kept: false,
    });
  }
  return rows.reverse();
}

export function GirthTable({ rows, level, onLevel }: { rows: readonly GirthRow[]; level: number | null; onLevel: (height_mm: number) => void }) {
  const nearest = level === null ? null : rows.reduce<GirthRow | null>((best, one) => (!best || Math.abs(one.height_mm - level) < Math.abs(best.height_mm - level) ? one : best), null);
  const figure = (value: number | null, decimals: number) => (value === null ? "–" : value.toFixed(decimals));
  return (
    <table class={rows.some((one) => !one.kept) ? "preview" : ""}>
      <thead>
        <tr>
          <th class="num">{t("th.height")}</th>
          <th class="num">{t("th.girth")}</th>
          <th class="num">±</th>
          <th class="num">{t("th.area")}</th>
          <th class="num">{t("th.below")}</th>
        </tr>
      </thead>
      <tbody>
        {rows.map((one) => {
          const on = nearest === one && level !== null && Math.abs(one.height_mm - level) < 10;
          return (
            <tr key={one.height_mm} class={`pick ${on ? "on" : ""}`} tabIndex={0} aria-current={on || undefined} onClick={() => onLevel(one.height_mm)} onFocus={() => onLevel(one.height_mm)}>
              <td class="num">{one.height_mm.toFixed(0)}</td>
              <td class="num">{figure(one.girth, 1)}</td>
              <td class="num soft">{figure(one.within, 1)}</td>
              <td class="num soft">{figure(one.area_cm2, 1)}</td>
              <td class="num soft">{figure(one.below_ml, 0)}</td>
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}
