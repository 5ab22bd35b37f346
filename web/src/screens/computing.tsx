/**
 * While the shape is computed: the stage in plain words, the time left, the elapsed time, and the
 * cameras, points and surface as they come. Also where it stopped, and how it goes on.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";

import { type Schemas, answerOf, api, bytesOf } from "../api/client";
import { decodeBlocks, surfaceOf } from "../api/blocks";
import { Icon } from "../design/icons";
import { Button, Confirm, Notice } from "../design/parts";
import { Refusal } from "../design/refusal";
import { guessFrame } from "../geometry/guess";
import { duration } from "../numbers";
import { perform } from "../state/acts";
import { useAct, useQuery } from "../state/requests";
import { go, href } from "../state/route";
import { expert } from "../state/settings";
import { t, tOr } from "../texts";
import { Stage, type Shown } from "../viewer/stage";
import type { Mode } from "../viewer/surface";
import { inParts } from "../words";
import { PointCloud } from "./point-cloud";
import type { OpenCase } from "./open-case";

type Job = Schemas["JobReply"];

const ANNOUNCED_MS = 10_000;

export function Computing({ openCase, onLook }: { openCase: OpenCase; onLook: (() => void) | null }) {
  const path = { params: { path: { case_id: openCase.id } } };
  const job = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/job", path)), [openCase.id, openCase.changes.job, openCase.info.state]);
  const act = useAct();
  const stopping = useSignal(false);
  const one = job.value.value;
  const now = useElapsed(one);
  const announced = useAnnounced(one);

  const call = (what: "pause" | "resume" | "cancel") =>
    act.run(async () => {
      stopping.value = false;
      await perform(openCase.id, "post", `/api/v1/cases/{case_id}/job/${what}`, path, { done: job.put, again: job.again, askedSince: job.askedSince });
      await openCase.again();
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
              <a class="btn" href={href.step(openCase.id, "capture")}>
                {t("next.capture")}
              </a>
            }
          />
        )}
      </main>
    );
  const active = isActive(one);
  const failed = hasFailed(one);
  return (
    <div class="work">
      <Arriving openCase={openCase} job={one} failed={failed} />
      <aside class="pane" aria-label={t("step.result")}>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <h1 class="job-head">{headWords(one)}</h1>
            <p class="unseen" aria-live="polite">
              {announced}
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
          <JobButtons
            job={one}
            caseId={openCase.id}
            onPause={() => void call("pause")}
            onResume={() => void call("resume")}
            onStop={() => (stopping.value = true)}
          />
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

const isActive = ({ state }: Job): boolean => state === "running" || state === "held" || state === "queued";
const hasFailed = ({ state }: Job): boolean => state === "refused" || state === "failed";

/** How far the run is, in one line. */
function headWords(job: Job): string {
  if (job.state === "running") return t("job.running");
  if (job.state === "held") return t("case.state.held");
  if (job.state === "queued") return t("job.queued", job.before);
  if (job.state === "finished") return t("case.state.finished");
  if (hasFailed(job)) return t("job.refused");
  return t("job.stopped", job.stages.filter((one) => one.state === "done").length, job.stages.length);
}

interface ButtonsProps {
  readonly job: Job;
  readonly caseId: string;
  readonly onPause: () => void;
  readonly onResume: () => void;
  /** Asks before the run is cancelled. */
  readonly onStop: () => void;
}

/** What can be done to the run as it stands. */
function JobButtons({ job, caseId, onPause, onResume, onStop }: ButtonsProps) {
  const cancel = (
    <Button big onClick={onStop}>
      {t("cancel")}
    </Button>
  );
  if (job.state === "queued") return cancel;
  if (job.state === "running")
    return (
      <div class="two-buttons">
        <Button big icon="pause" onClick={onPause}>
          {t("job.pause")}
        </Button>
        {cancel}
      </div>
    );
  if (job.state === "held")
    return (
      <div class="two-buttons">
        <Button go big icon="play" onClick={onResume}>
          {t("job.resume")}
        </Button>
        {cancel}
      </div>
    );
  if (job.state === "interrupted" || job.state === "cancelled")
    return (
      <Button go big icon="play" onClick={onResume}>
        {t("job.continue")}
      </Button>
    );
  if (!hasFailed(job)) return null;
  return (
    <Button go big onClick={() => go(href.step(caseId, "capture"))}>
      {t("next.capture")}
    </Button>
  );
}

const stageName = ({ name, title }: Job["stages"][number]): string => tOr(`stage.${name}`, title);

/** The stage as a screen reader hears it: the first at once, then at most one every ten seconds. */
function useAnnounced(job: Job | null): string {
  const [announced, setAnnounced] = useState("");
  const stage = job?.stages.find((one) => one.state === "running");
  useEffect(() => {
    if (!announced && stage) return setAnnounced(stageName(stage));
    const wait = setTimeout(() => setAnnounced(stage ? stageName(stage) : ""), ANNOUNCED_MS);
    return () => clearTimeout(wait);
  }, [stage?.name]);
  return announced;
}

function Stages({ stages }: { stages: Job["stages"] }) {
  return (
    <ol class="stages">
      {stages.map((s, i) => (
        <li key={s.name} class={s.state}>
          <span class="n">{s.state === "done" ? <Icon name="tick" small /> : i + 1}</span>
          <span class="grow">
            {stageName(s)}
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

function Failure({ job }: { job: Job }) {
  const { what, more } = job.finding ? inParts(job.finding) : { what: "", more: "" };
  return (
    <Notice tone="red" title={what}>
      <p>{more}</p>
      {expert.value && <p class="mono">{job.kind}</p>}
    </Notice>
  );
}

function leftWords(left: NonNullable<Job["left"]>): string {
  const low = duration(left.least_s);
  const high = duration(left.most_s);
  return low === high ? t("job.about", high) : t("job.between", low, high);
}

/** Elapsed seconds: the server's, counted on between its answers. It never goes back. */
function useElapsed(job: Job | null): number {
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
function Arriving({ openCase, job, failed }: { openCase: OpenCase; job: Job; failed: boolean }) {
  const mode = useSignal<Mode>("surface");
  const { there } = job;
  const path = { params: { path: { case_id: openCase.id } } };
  const shape = useQuery(async (): Promise<Shown | null> => {
    if (!there.surface || failed) return null;
    const { bytes } = await bytesOf(`/cases/${openCase.id}/job/surface`);
    const surface = surfaceOf(decodeBlocks(bytes));
    return { surface, frame: guessFrame(surface.positions, surface.indices), aligned: false };
  }, [openCase.id, there.surface, failed, isDone(job, "measure")]);
  const dots = useQuery(async () => {
    if (failed || !(there.cameras || there.cloud)) return null;
    const cameras = there.cameras ? await answerOf(api.GET("/api/v1/cases/{case_id}/job/cameras", path)) : [];
    const cloud = there.cloud ? decodeBlocks((await bytesOf(`/cases/${openCase.id}/job/cloud?most=30000`)).bytes) : null;
    return { cameras, cloud };
  }, [openCase.id, there.cameras, there.cloud, failed]);
  if (shape.value.value)
    return <Stage shown={shape.value.value} label={t("stage.limb")} mode={mode} modes={["surface", "photo", "sure"]} keys={t("job.keys.surface")} />;
  if (dots.value.value) return <PointCloud cameras={dots.value.value.cameras} cloud={dots.value.value.cloud} />;
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

const isDone = (job: Job, name: string) => job.stages.some((s) => s.name === name && s.state === "done");
