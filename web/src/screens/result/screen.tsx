/**
 * Result: can I trust it, and where not? While it is computed: how far, how long, and what is there.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { Vector3 } from "three";

import { answerOf, api } from "../../api/client";
import figures from "../../api/figures.json";
import { Icon } from "../../design/icons";
import { Button, Notice } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { type Sureness, surenessOf } from "../../geometry/sureness";
import { type Vec3, apply, xyz } from "../../geometry/vectors";
import { fixed, within } from "../../numbers";
import { perform } from "../../state/acts";
import { useAct, useQuery } from "../../state/requests";
import { go, href } from "../../state/route";
import { expert } from "../../state/settings";
import { t } from "../../texts";
import type { Mark } from "../../viewer/overlay";
import { Stage, type Shown } from "../../viewer/stage";
import type { Mode } from "../../viewer/surface";
import type { Viewer } from "../../viewer/viewer";
import { Computing } from "../computing";
import { type Limb, useLimb } from "../limb";
import { PointCard } from "../point-card";
import type { CaseProps } from "../open-case";
import { GirthTable, rowsOf } from "./girths";
import { KitLines } from "./kit";
import { NoteLines, SizeLines, VerdictLines } from "./verdict";

export function ResultScreen({ openCase }: CaseProps) {
  const working = ["computing", "held", "interrupted", "cancelled", "refused", "failed"].includes(openCase.info.state);
  const shape = openCase.info.steps.some((step) => step.name === "align" && step.state !== "locked");
  const stay = useSignal(false);
  useEffect(() => {
    stay.value = false;
  }, [openCase.info.state]);
  if ((working && !stay.value) || !shape) return <Computing openCase={openCase} onLook={shape ? () => (stay.value = true) : null} />;
  return <Finished openCase={openCase} />;
}

function Finished({ openCase }: CaseProps) {
  const { limb, asked } = useLimb(openCase, "scan");
  const mode = useSignal<Mode>("sure");
  const level = useSignal<number | null>(null);
  const picked = useSignal<Vec3 | null>(null);
  const act = useAct();
  const viewer = useRef<Viewer | null>(null);
  const path = { params: { path: { case_id: openCase.id } } };
  const aligned = limb?.reply.aligned ?? false;
  const measures = useQuery(
    async () =>
      aligned
        ? await answerOf(
            api.POST("/api/v1/cases/{case_id}/measures", {
              ...path,
              body: {
                of: "scan",
                spacing_mm: figures.LEVEL_SPACING_MM,
                volumes: [],
                lengths: [],
                tapes: [],
                along: false,
                inside: false,
                unaligned: false,
                sheet: false,
                shoe_heel_mm: 0,
                shoe_sole_mm: 0,
                with_tape: false,
              },
            }),
          )
        : null,
    [openCase.id, aligned, limb?.reply.sha256],
  );
  const kit = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/kit", path)), [openCase.id, openCase.info.state]);
  const rows = useMemo(() => rowsOf(limb, measures.value.value), [limb, measures.value.value]);
  const shown = useMemo<Shown | null>(() => (limb ? { surface: limb.fetched.data, frame: limb.frame, aligned: limb.reply.aligned } : null), [limb]);
  useEffect(() => {
    if (level.value === null && rows.length) level.value = rows[Math.min(4, rows.length - 1)].height_mm;
  }, [rows]);
  const measured = useMemo(() => (limb ? surenessOf(limb.fetched.data) : null), [limb]);
  const refresh = () =>
    act.run(async () => {
      await perform(openCase.id, "post", "/api/v1/cases/{case_id}/limb/refresh", path);
      await asked.again();
    });
  const look = ({ where, normal }: Sureness) => {
    picked.value = where;
    viewer.current?.lookAt(new Vector3(...where), new Vector3(...normal));
  };
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
        onClick={(hit) => (picked.value = hit && xyz(hit.point))}
        marks={limb ? picks(picked.value) : []}
      >
        {picked.value && limb && <PointCard openCase={openCase} point={picked.value} onClose={() => (picked.value = null)} />}
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
            <VerdictLines info={openCase.info} />
            <SizeLines tapes={kit.value.value?.tapes ?? []} verdict={openCase.info.verdict} />
            {measured && <Figures measured={measured} photos={openCase.info.photos} />}
            {measured && limb && measured.worst_mm > 0 && <LeastSure measured={measured} limb={limb} onShow={look} />}
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
          <NoteLines notes={kit.value.value?.notes ?? []} verdict={openCase.info.verdict} />
          <section class="small-note">
            <a href={href.step(openCase.id, "compare")}>{t("result.compare")}</a>
          </section>
          <section class="small faint">{t(aligned ? "result.heights" : "result.heights.guess")}</section>
          {expert.value && limb && <Expert caseId={openCase.id} limb={limb} />}
        </div>
        <div class="next">
          <Button go big trailing="next" onClick={() => go(href.step(openCase.id, aligned ? "measure" : "align"))}>
            {aligned ? t("result.next.measure") : t("result.next")}
          </Button>
          {!aligned && <p class="small faint">{t("result.guess")}</p>}
        </div>
      </aside>
    </div>
  );
}

const picks = (point: Vec3 | null): Mark[] => (point ? [{ name: "·", label: "", point: new Vector3(...point), state: "chosen" }] : []);

/** How much was measured, how sure it is, and of how many photos. */
function Figures({ measured, photos }: { measured: Sureness; photos: number }) {
  const all = measured.share > 0.9995;
  return (
    <div class="fig">
      <div>
        <h3>{t("fig.measured")}</h3>
        <b>{fixed(100 * measured.share, all ? 0 : 1)} %</b>
        <span class="small faint">{all ? t("fig.nothing.filled") : t("fig.filled", fixed(100 - 100 * measured.share, 1))}</span>
      </div>
      <div>
        <h3>{t("fig.sure")}</h3>
        <b>± {within(measured.typical, 2)} mm</b>
        <span class="small faint">{t("fig.sure.half")}</span>
      </div>
      <div>
        <h3>{t("held.photos")}</h3>
        <b>{photos}</b>
        <span class="small faint">{t("fig.photos.sent")}</span>
      </div>
    </div>
  );
}

/** Where the surface is least sure. */
function LeastSure({ measured, limb, onShow }: { measured: Sureness; limb: Limb; onShow: (at: Sureness) => void }) {
  const height_mm = Math.max(0, apply(limb.frame, measured.where)[2]);
  return (
    <div class="todo">
      <Icon name="eye" />
      <span>
        {t("result.least", within(measured.worst_mm, 1), fixed(height_mm, 0))}{" "}
        <button type="button" class="linkish" onClick={() => onShow(measured)}>
          {t("result.show")}
        </button>
      </span>
    </div>
  );
}

/** What the surface is made of. */
function Expert({ caseId, limb }: { caseId: string; limb: Limb }) {
  return (
    <section class="mono">
      {limb.reply.vertices} {t("expert.vertices")}, {limb.reply.faces} {t("expert.triangles")}
      <br />
      sha256 {limb.reply.sha256.slice(0, 16)}…<br />
      <a href={`/api/v1/cases/${caseId}/report/report`} target="_blank" rel="noreferrer">
        {t("expert.report")}
      </a>
    </section>
  );
}
