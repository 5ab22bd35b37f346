/**
 * While the shape is computed: the stage in plain words, the time left, the elapsed time, and the
 * cameras, points and surface as they come. Also where it stopped, and how it goes on.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";

import { type Schemas, api, bytesOf, taken } from "../api/client";
import { decodeBlocks, surfaceOf } from "../api/blocks";
import { Icon } from "../design/icons";
import { Button, Confirm, Notice } from "../design/parts";
import { Refusal } from "../design/refusal";
import { guessFrame } from "../geometry/guess";
import { perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { expert } from "../state/settings";
import { duration, t, tOr } from "../texts";
import { Stage, type Shown } from "../viewer/stage";
import type { Mode } from "../viewer/surface";
import { inParts } from "../words";
import { Dots } from "./dots";
import type { Room } from "./room";

export function Computing({ room, onLook }: { room: Room; onLook: (() => void) | null }) {
  const path = { params: { path: { case_id: room.id } } };
  const job = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/job", path)), [room.id, room.news.job, room.info.state]);
  const act = useAct();
  const stopping = useSignal(false);
  const one = job.value.value;
  const now = useElapsed(one);

  const told = useRef("");
  const announced = useSignal("");
  const stage = one?.stages.find((s) => s.state === "running");
  useEffect(() => {
    const wait = setTimeout(() => {
      const text = stage ? tOr(`stage.${stage.name}`, stage.title) : "";
      if (text !== told.current) announced.value = told.current = text;
    }, 10_000);
    if (!told.current && stage) announced.value = told.current = tOr(`stage.${stage.name}`, stage.title);
    return () => clearTimeout(wait);
  }, [stage?.name]);

  const call = (what: "pause" | "resume" | "cancel") =>
    act.run(async () => {
      stopping.value = false;
      await perform(room.id, "post", `/api/v1/cases/{case_id}/job/${what}`, path, { done: job.put, again: job.again, askedSince: job.askedSince });
      await room.again();
    });

  if (!one || one.state === "none")
    return (
      <main class="cases" id="content" tabIndex={-1}>
        <Refusal refused={job.refused.value} />
        {one && (
          <Notice
            tone="plain"
            title={t("result.none")}
            action={
              <a class="btn" href={href.step(room.id, "capture")}>
                {t("next.capture")}
              </a>
            }
          />
        )}
      </main>
    );
  const active = one.state === "running" || one.state === "held" || one.state === "queued";
  const done = one.stages.filter((s) => s.state === "done").length;
  const failed = one.state === "refused" || one.state === "failed";
  return (
    <div class="work">
      <Arriving room={room} job={one} failed={failed} />
      <aside class="pane" aria-label={t("step.result")}>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <h1 class="job-head">
              {one.state === "running"
                ? t("job.running")
                : one.state === "held"
                  ? t("job.held")
                  : one.state === "queued"
                    ? t("job.queued", one.before)
                    : one.state === "finished"
                      ? t("case.state.finished")
                      : failed
                        ? t("job.refused")
                        : t("job.stopped", done, one.stages.length)}
            </h1>
            <p class="unseen" aria-live="polite">
              {announced.value}
            </p>
            {failed && <Failure job={one} />}
            {!failed && !active && one.state !== "finished" && <p class="soft">{t("job.nothing.lost")}</p>}
            {active && (
              <dl class="times">
                <div>
                  <dt>{t("job.left")}</dt>
                  <dd>{one.left ? leftWords(one.left) : "–"}</dd>
                </div>
                <div>
                  <dt>{t("job.elapsed")}</dt>
                  <dd class="tabular">{duration(now)}</dd>
                </div>
              </dl>
            )}
            {active && one.left && !one.left.known && <p class="small faint">{t("job.first.run")}</p>}
            <Refusal refused={act.refused.value} />
          </section>
          <section class="tab">
            <Stages stages={one.stages} />
          </section>
        </div>
        {stopping.value && (
          <Confirm title={t("job.cancel.sure")} yes={t("job.cancel")} onYes={() => void call("cancel")} onNo={() => (stopping.value = false)}>
            <p>{t("job.cancel.what")}</p>
          </Confirm>
        )}
        <div class="next">
          {one.state === "running" && (
            <div class="two-buttons">
              <Button big icon="pause" onClick={() => void call("pause")}>
                {t("job.pause")}
              </Button>
              <Button big onClick={() => (stopping.value = true)}>
                {t("cancel")}
              </Button>
            </div>
          )}
          {one.state === "queued" && (
            <Button big onClick={() => (stopping.value = true)}>
              {t("cancel")}
            </Button>
          )}
          {one.state === "held" && (
            <div class="two-buttons">
              <Button go big icon="play" onClick={() => void call("resume")}>
                {t("job.resume")}
              </Button>
              <Button big onClick={() => (stopping.value = true)}>
                {t("cancel")}
              </Button>
            </div>
          )}
          {(one.state === "interrupted" || one.state === "cancelled") && (
            <Button go big icon="play" onClick={() => void call("resume")}>
              {t("job.continue")}
            </Button>
          )}
          {failed && (
            <Button go big onClick={() => go(href.step(room.id, "capture"))}>
              {t("next.capture")}
            </Button>
          )}
          {onLook && (
            <p>
              <button type="button" class="linkish" onClick={onLook}>
                {t("job.look.before")}
              </button>
            </p>
          )}
          {active && <p class="small faint">{t("job.close.page")}</p>}
        </div>
      </aside>
    </div>
  );
}

function Stages({ stages }: { stages: Schemas["JobReply"]["stages"] }) {
  return (
    <ol class="stages">
      {stages.map((s, i) => (
        <li key={s.name} class={s.state}>
          <span class="n">{s.state === "done" ? <Icon name="tick" small /> : i + 1}</span>
          <span class="grow">
            {tOr(`stage.${s.name}`, s.title)}
            {s.state === "running" && s.total > 0 && (
              <svg class="stage-bar" viewBox="0 0 100 4" preserveAspectRatio="none" role="img" aria-label={`${s.done} / ${s.total}`}>
                <rect class="all" width="100" height="4" />
                <rect class="part" width={(100 * s.done) / s.total} height="4" />
              </svg>
            )}
            {expert.value && <span class="mono"> {s.name}</span>}
          </span>
          <span class="num faint small">{s.state === "done" ? duration(s.seconds) : s.state === "running" && s.total ? `${s.done} / ${s.total}` : ""}</span>
        </li>
      ))}
    </ol>
  );
}

function Failure({ job }: { job: Schemas["JobReply"] }) {
  const { what, more } = job.finding ? inParts(job.finding) : { what: "", more: "" };
  return (
    <Notice tone="red" title={what}>
      <p>{more}</p>
      {expert.value && <p class="mono">{job.kind}</p>}
    </Notice>
  );
}

function leftWords(left: NonNullable<Schemas["JobReply"]["left"]>): string {
  const low = duration(left.least_s);
  const high = duration(left.most_s);
  return low === high ? t("job.about", high) : t("job.between", low, high);
}

/** Elapsed seconds: the server's, counted on between its answers. It never goes back. */
function useElapsed(job: Schemas["JobReply"] | null): number {
  const [now, setNow] = useState(0);
  const from = useRef({ at: 0, elapsed: 0 });
  useEffect(() => {
    if (!job) return;
    from.current = { at: performance.now(), elapsed: Math.max(job.elapsed_s, job.state === "running" ? now : 0) };
    setNow(from.current.elapsed);
    if (job.state !== "running") return;
    const beat = setInterval(() => setNow(from.current.elapsed + (performance.now() - from.current.at) / 1000), 1000);
    return () => clearInterval(beat);
  }, [job]);
  return now;
}

/** What is there already: cameras and points, then the surface. */
function Arriving({ room, job, failed }: { room: Room; job: Schemas["JobReply"]; failed: boolean }) {
  const mode = useSignal<Mode>("surface");
  const { there } = job;
  const path = { params: { path: { case_id: room.id } } };
  const shape = useAsked(async (): Promise<Shown | null> => {
    if (!there.surface || failed) return null;
    const { bytes } = await bytesOf(`/cases/${room.id}/job/surface`);
    const surface = surfaceOf(decodeBlocks(bytes));
    return { surface, frame: guessFrame(surface.positions, surface.indices), aligned: false };
  }, [room.id, there.surface, failed, done(job, "measure")]);
  const dots = useAsked(async () => {
    if (failed || !(there.cameras || there.cloud)) return null;
    const cameras = there.cameras ? await taken(api.GET("/api/v1/cases/{case_id}/job/cameras", path)) : [];
    const cloud = there.cloud ? decodeBlocks((await bytesOf(`/cases/${room.id}/job/cloud?most=30000`)).bytes) : null;
    return { cameras, cloud };
  }, [room.id, there.cameras, there.cloud, failed]);
  if (shape.value.value)
    return <Stage shown={shape.value.value} label={t("stage.limb")} mode={mode} modes={["surface", "photo", "sure"]} keys={t("job.keys.surface")} />;
  if (dots.value.value) return <Dots cameras={dots.value.value.cameras} cloud={dots.value.value.cloud} />;
  return (
    <main class="stage" id="content" tabIndex={-1}>
      <div class="empty">
        <Icon name={failed ? "stop" : "limb"} />
        <h2>{failed ? t("job.no.picture") : t("job.waits")}</h2>
        {!failed && <p>{t("job.waits.why")}</p>}
      </div>
    </main>
  );
}

const done = (job: Schemas["JobReply"], name: string) => job.stages.some((s) => s.name === name && s.state === "done");
