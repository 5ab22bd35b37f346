/**
 * Measure: does my tape agree? Girths by level beside the limb, with a column for the tape.
 *
 * A conflict is judged by the server, and comes first. A reading counts as kept once the server says so;
 * until it has also compared it, nothing is said of agreement.
 */
import { useSignal } from "@preact/signals";
import { Fragment } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";

import { ROOT, Refused, type Schemas, api, refusedBy, taken } from "../api/client";
import { Button, Chip, Notice, NumberField, Segments, WrongNumber, useTyped } from "../design/parts";
import { Refusal } from "../design/refusal";
import { signed } from "../geometry/scales";
import { cut, heightsOf } from "../geometry/section";
import { perform, pendingAt } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { expert } from "../state/settings";
import { language, t } from "../texts";
import { Stage, type Shown } from "../viewer/stage";
import type { Mode } from "../viewer/surface";
import { told } from "../words";
import { useLimb } from "./limb";
import { type Reading, heightIs, judged, withPending } from "./readings";
import type { RoomProps } from "./room";

type Level = Schemas["Level"];
const TAPE = "/api/v1/cases/{case_id}/tape";

export function MeasureScreen({ room }: RoomProps) {
  const of = useSignal<"scan" | "rectified">("scan");
  const { limb, asked } = useLimb(room, of.value);
  const path = { params: { path: { case_id: room.id } } };
  const mode = useSignal<Mode>("surface");
  const level = useSignal<number | null>(null);
  const spacing = useSignal(20);
  const sock = useSignal(0);
  const act = useAct();
  const aligned = limb?.reply.aligned ?? false;
  const body = (): Schemas["AskMeasures"] => ({ of: of.value, spacing_mm: spacing.value, sock_mm: sock.value || null, volumes: [], lengths: pairs(limb?.reply), tapes: [], inside: false, unaligned: false, sheet: false, shoe_heel_mm: 0, shoe_sole_mm: 0, with_tape: true });
  const measures = useAsked(
    async () => (aligned ? await taken(api.POST("/api/v1/cases/{case_id}/measures", { ...path, body: { ...body(), lengths: body().lengths.map(([a, b]) => [a, b]) } })) : null),
    [room.id, aligned, room.news.work, of.value, spacing.value, sock.value],
  );
  const found = measures.value.value;
  const kept = useAsked(() => taken(api.GET(TAPE, path)), [room.id, room.news.work]);
  /** Why a reading was not kept, by its height. */
  const wrong = useSignal<ReadonlyMap<number, { readonly girth_mm: number | null; readonly refused: Refused }>>(new Map());
  const shown = useMemo<Shown | null>(() => (limb ? { surface: limb.fetched.data, frame: limb.frame, aligned } : null), [limb]);
  const heights = useMemo(() => (limb ? heightsOf(limb.fetched.data.positions, limb.frame) : null), [limb]);
  const rows = useMemo(() => [...(found?.levels ?? [])].reverse(), [found]);
  useEffect(() => {
    if (level.value === null && rows.length) level.value = rows[Math.min(4, rows.length - 1)].height_mm;
  }, [rows]);
  const here = useMemo(
    () => (limb && heights && level.value !== null ? cut(limb.fetched.data.positions, limb.fetched.data.indices, heights, level.value, limb.frame) : null),
    [limb, heights, level.value],
  );
  /** The row of this very height: its figures are the server's, which know what fine relief the surface lost. */
  const row = rows.find((one) => level.value !== null && Math.abs(one.height_mm - level.value) < 0.05);
  const from = found?.reference_height_mm ?? 0;
  const tape = judged(withPending(kept.value.value ?? [], pendingAt(room.id, TAPE)), measures.busy.value ? [] : (found?.tape ?? []));
  const waits = tape.some((one) => one.verdict === null);
  const comparing = t(measures.refused.value ? "measure.compared.not" : "measure.comparing");
  const conflicts = tape.filter((one) => one.verdict?.conflict);

  const said = (height_mm: number, refused: Refused | null, girth_mm: number | null) => {
    const next = new Map([...wrong.value].filter(([height]) => !heightIs(height, height_mm)));
    if (refused) next.set(height_mm, { girth_mm, refused });
    wrong.value = next;
  };
  /** Going on in spite of a conflict is an act: the record tells it, with its time. */
  const goOn = () =>
    act.run(async () => {
      for (const { height_mm, girth_mm, verdict } of conflicts)
        if (!verdict?.accepted) await perform(room.id, "post", "/api/v1/cases/{case_id}/tape/accept", { ...path, body: { height_mm, girth_mm } });
      go(href.step(room.id, "rectify"));
    });
  const keep = (height_mm: number, girth_mm: number | null) =>
    act.run(async () => {
      said(height_mm, null, girth_mm);
      try {
        await perform(room.id, "patch", TAPE, { ...path, body: { height_mm, girth_mm } }, { done: kept.put, again: kept.again });
      } catch (error) {
        if (error instanceof Refused) said(height_mm, error, girth_mm);
        throw error;
      }
      await measures.again();
    });
  /** Beside the reading that was refused: it is not in the field any more. */
  const notKept = (height_mm: number) => {
    const found = [...wrong.value].find(([height]) => heightIs(height, height_mm))?.[1];
    return (
      found && (
        <tr key={`not kept ${height_mm}`}>
          <td colSpan={5}>
            <p class="wrong" role="alert">
              {t("measure.not.kept", height_mm.toFixed(0), found.girth_mm ?? "–")} {found.refused.message}
            </p>
          </td>
        </tr>
      )
    );
  };
  const sheet = () =>
    act.run(async () => {
      const response = await fetch(`${ROOT}/cases/${room.id}/measures.csv`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body()), credentials: "same-origin" });
      if (!response.ok) throw refusedBy(response.status, await response.json().catch(() => null));
      saveAs(await response.blob(), `${room.id}-measures.csv`);
    });
  const edited = room.info.steps.some((step) => step.name === "rectify" && step.state === "done");

  return (
    <div class="work">
      <Stage shown={shown} label={t("stage.limb")} mode={mode} modes={["surface", "photo", "sure"]} level={level} keys={t("measure.keys")} marks={[]}>
        {asked.refused.value && (
          <div class="stage-note">
            <Refusal refused={asked.refused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("step.measure")}>
        <h1 class="unseen">{t("step.measure")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <div class="row-head">
              <h2 aria-live="polite">{tape.length === 0 ? t("measure.title") : waits ? comparing : conflicts.length ? t("measure.conflicts", conflicts.length) : t("measure.agrees")}</h2>
              <span class="grow" />
              {tape.length > 0 && <Chip tone={waits ? "plain" : conflicts.length ? "amber" : "green"}>{t("measure.tapes", tape.length)}</Chip>}
            </div>
            {conflicts.map((one) => (
              <Notice
                key={one.height_mm}
                tone="amber"
                title={t("measure.conflict", one.height_mm.toFixed(0), one.girth_mm.toFixed(1), one.verdict?.measured_mm?.value.toFixed(1) ?? "–", signed(one.verdict?.difference_mm ?? 0))}
                action={<Button onClick={() => (level.value = one.height_mm + from)}>{t("result.show")}</Button>}
              >
                {t("measure.conflict.do", (one.verdict?.within_mm ?? 0).toFixed(1))}
              </Notice>
            ))}
            <p class="here" role="status">
              {level.value !== null && here && Number.isFinite(here.tape_mm) && t("measure.here", level.value.toFixed(0), (row?.tape_mm?.value ?? here.tape_mm).toFixed(1), (row?.contour_mm?.value ?? here.contour_mm).toFixed(1))}
            </p>
            {aligned && !found && measures.busy.value && (
              <p class="soft small-note" role="status">
                {t("measure.busy")}
              </p>
            )}
            <Refusal refused={(wrong.value.size ? null : act.refused.value) ?? kept.refused.value ?? measures.refused.value} />
            {!aligned && limb && (
              <Notice
                tone="plain"
                title={t("measure.needs")}
                action={
                  <a class="btn" href={href.step(room.id, "align")}>
                    {t("step.align")}
                  </a>
                }
              />
            )}
          </section>
          {found && (
            <section class="tab">
              <table>
                <thead>
                  <tr>
                    <th class="num">{t("th.height")}</th>
                    <th class="num">{t("th.girth")}</th>
                    <th class="num">±</th>
                    <th class="num">{t("th.tape")}</th>
                    <th class="num">{t("th.difference")}</th>
                  </tr>
                </thead>
                <tbody>
                  {rows.map((one) => (
                    <Fragment key={one.height_mm}>
                      <LevelRow one={one} on={level.value !== null && Math.abs(level.value - one.height_mm) < spacing.value / 2} tape={tape.find((r) => heightIs(r.height_mm, one.from_reference_mm))} onLevel={() => (level.value = one.height_mm)} onTape={(girth) => void keep(one.from_reference_mm, girth)} />
                      {notKept(one.from_reference_mm)}
                    </Fragment>
                  ))}
                  {tape
                    .filter((r) => !rows.some((one) => heightIs(r.height_mm, one.from_reference_mm)))
                    .map((r) => (
                      <tr key={r.height_mm} class={`pick ${r.verdict?.conflict ? "conflict" : ""}`} onClick={() => (level.value = r.height_mm + from)}>
                        <td class="num">{r.height_mm.toFixed(0)}</td>
                        <td class="num">{r.verdict?.measured_mm?.value.toFixed(1) ?? "–"}</td>
                        <td class="num soft">{r.verdict?.measured_mm?.within?.toFixed(1) ?? "–"}</td>
                        <td class="num">
                          <TapeInput height_mm={r.height_mm} value={r.girth_mm} onKeep={(girth) => void keep(r.height_mm, girth)} />
                        </td>
                        <Difference of={r} />
                      </tr>
                    ))}
                  {[...wrong.value.keys()].filter((height) => !rows.some((one) => heightIs(height, one.from_reference_mm))).map(notKept)}
                </tbody>
              </table>
              {level.value !== null && !rows.some((one) => Math.abs(one.height_mm - (level.value ?? 0)) < 0.5) && (
                <div class="row-head at-level">
                  <span class="small-note">{t("measure.tape.here", (level.value - from).toFixed(0))}</span>
                  <TapeInput key={Math.round(level.value - from)} height_mm={Math.round(level.value - from)} value={null} onKeep={(girth) => void keep(Math.round((level.value ?? 0) - from), girth)} />
                </div>
              )}
            </section>
          )}
          {found && (
            <section>
              <h3>{t("measure.curve")}</h3>
              <Curve levels={found.levels} tape={tape} from={from} />
            </section>
          )}
          {found && found.lengths.length > 0 && (
            <section>
              <h3>{t("measure.lengths")}</h3>
              <table class="kv">
                <tbody>
                  {found.lengths.map((one) => (
                    <tr key={one.start + one.end}>
                      <td>
                        {one.start} – {one.end}
                      </td>
                      <td>
                        {one.over_surface_mm.value.toFixed(1)} mm
                        {one.over_surface_mm.within ? <span class="faint"> ± {Math.max(0.1, one.over_surface_mm.within).toFixed(1)}</span> : null}
                      </td>
                    </tr>
                  ))}
                </tbody>
              </table>
            </section>
          )}
          <section>
            <div class="row2">
              <NumberField label={t("measure.spacing")} unit="mm" step={5} decimals={1} min={1} max={200} value={spacing.value} onChange={(value) => (spacing.value = value)} />
              <NumberField label={t("measure.sock")} unit="mm" step={0.1} decimals={2} min={0} max={20} value={sock.value} onChange={(value) => (sock.value = value)} />
            </div>
            {edited && (
              <div class="setting">
                <span>{t("measure.of")}</span>
                <Segments label={t("measure.of")} value={of.value} options={[{ value: "scan", text: t("measure.of.scan") }, { value: "rectified", text: t("measure.of.rectified") }]} onChange={(value) => (of.value = value)} />
              </div>
            )}
            {(of.value === "rectified" || sock.value > 0) && <p class="small faint">{t("measure.tape.by")}</p>}
            <div class="acts">
              <Button icon="save" onClick={() => void sheet()}>
                {t("measure.csv")}
              </Button>
            </div>
            {found && <p class="small faint">{t("measure.counted", found.counted_from)}</p>}
            {expert.value && found?.notes.map((one) => <p class="small faint">{told(one)}</p>)}
          </section>
        </div>
        <div class="next">
          <Button go big trailing="next" off={!aligned ? t("measure.needs") : waits ? comparing : act.busy.value ? t("loading") : null} onClick={goOn}>
            {conflicts.length ? t("measure.next.anyway") : t("measure.next")}
          </Button>
          {conflicts.length > 0 && <p class="small soft">{t("measure.next.why")}</p>}
        </div>
      </aside>
    </div>
  );
}

/** Lengths between neighbouring places, at most four. */
function pairs(limb: Schemas["LimbReply"] | undefined): [string, string][] {
  const names = limb?.places.map((one) => one.name) ?? [];
  return names.slice(1, 5).map((name, i) => [names[i], name]);
}

export function saveAs(content: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** What the server says of a reading; nothing where it has not compared it yet. */
function Difference({ of }: { of?: Reading }) {
  const verdict = of?.verdict;
  const off = verdict?.difference_mm;
  return <td class={`num ${verdict?.conflict ? "a" : "soft"}`}>{of && !verdict ? "…" : off === null || off === undefined ? (verdict?.reason ? told(verdict.reason) : "") : signed(off)}</td>;
}

function LevelRow({ one, on, tape, onLevel, onTape }: { one: Level; on: boolean; tape?: Reading; onLevel: () => void; onTape: (girth: number | null) => void }) {
  return (
    <tr class={`pick ${on ? "on" : ""} ${tape?.verdict?.conflict ? "conflict" : ""}`} tabIndex={0} aria-current={on || undefined} onClick={onLevel} onFocus={onLevel} title={one.reasons?.map(told).join(" ")}>
      <td class="num">{one.from_reference_mm.toFixed(0)}</td>
      <td class="num">{one.tape_mm?.value.toFixed(1) ?? "–"}</td>
      <td class="num soft">{one.tape_mm?.within?.toFixed(1) ?? "–"}</td>
      <td class="num">
        <TapeInput height_mm={one.from_reference_mm} value={tape?.girth_mm ?? null} onKeep={onTape} />
      </td>
      <Difference of={tape} />
    </tr>
  );
}

function TapeInput({ height_mm, value, onKeep }: { height_mm: number; value: number | null; onKeep: (girth: number | null) => void }) {
  const typed = useTyped(value === null ? "" : String(value), onKeep, { mayBeEmpty: true });
  return (
    <>
      <input
        class="tape-input"
        inputMode="decimal"
        autocomplete="off"
        placeholder="mm"
        aria-label={t("measure.tape.at", height_mm.toFixed(0))}
        {...typed.input}
        onClick={(event) => event.stopPropagation()}
        onKeyDown={(event) => event.key === "Enter" && typed.commit()}
      />
      {typed.wrong && <WrongNumber text={typed.wrong} />}
    </>
  );
}

/** Girth over height, with the tape's readings as dots. */
function Curve({ levels, tape, from }: { levels: readonly Level[]; tape: readonly Reading[]; from: number }) {
  const holder = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!holder.current) return;
    const style = getComputedStyle(holder.current);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const all = [...levels.filter((one) => one.tape_mm).map((one) => [one.height_mm, one.tape_mm?.value ?? null, null] as const), ...tape.map((one) => [one.height_mm + from, null, one.girth_mm] as const)].sort((a, b) => a[0] - b[0]);
    if (!all.length) return;
    const axis = { stroke: colour("--ink-3"), grid: { stroke: colour("--line"), width: 1 }, ticks: { show: false }, font: '11px "Inter Variable", sans-serif' };
    const plot = new uPlot(
      {
        width: holder.current.clientWidth,
        height: 150,
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 26 },
          { ...axis, size: 40 },
        ],
        series: [{}, { stroke: colour("--accent"), width: 2, spanGaps: true, points: { show: false } }, { stroke: colour("--amber"), width: 0, points: { show: true, size: 8, fill: colour("--amber") } }],
      },
      [all.map((p) => p[0]), all.map((p) => p[1]), all.map((p) => p[2])],
      holder.current,
    );
    return () => plot.destroy();
  }, [levels, tape, language.value]);
  return <div ref={holder} class="curve" role="img" aria-label={t("measure.curve")} />;
}
