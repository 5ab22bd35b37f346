/** The app: which screen stands where, and what is said when the program does not answer. */
import { useSignal } from "@preact/signals";
import type { ComponentType } from "preact";
import { useEffect } from "preact/hooks";

import { answerOf, api, link } from "./api/client";
import { listen } from "./api/events";
import { Shell } from "./design/shell";
import { Button, Notice } from "./design/parts";
import { Refusal } from "./design/refusal";
import { CameraScreen } from "./screens/cameras";
import { CaptureScreen } from "./screens/capture";
import { headOf } from "./screens/case-head";
import { CasesScreen } from "./screens/cases";
import { HelpPanel } from "./screens/help";
import { PhoneScreen } from "./screens/phone";
import type { CaseProps } from "./screens/open-case";
import { SettingsScreen } from "./screens/settings";
import { forgotten, isOfFiles, missed, pending, perform } from "./state/acts";
import { useAct, useQuery } from "./state/requests";
import { useLoaded } from "./state/loaded";
import { type Page, href, place } from "./state/route";
import { t } from "./texts";
import { type Finding, told } from "./words";

type Screen = ComponentType<CaseProps>;
/** From when on it is said that something is not kept yet. */
const LATE_MS = 2500;

/** The screens with the canvas come in a file of their own, when the first of them is opened. */
const SCREENS: Record<Page, () => Promise<Screen>> = {
  capture: async () => CaptureScreen,
  compare: async () => (await import("./screens/work")).CompareScreen,
  result: async () => (await import("./screens/work")).ResultScreen,
  align: async () => (await import("./screens/work")).AlignScreen,
  measure: async () => (await import("./screens/work")).MeasureScreen,
  rectify: async () => (await import("./screens/work")).RectifyScreen,
  send: async () => (await import("./screens/work")).SendScreen,
  record: async () => (await import("./screens/work")).RecordScreen,
};

export function App() {
  const here = place.value;
  const helping = useSignal(false);
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      if (event.key !== "Escape" || !helping.value) return;
      event.stopImmediatePropagation(); // it closes the help, and drops no edit that is open beside it
      helping.value = false;
    };
    addEventListener("keydown", key, { capture: true });
    return () => removeEventListener("keydown", key, { capture: true });
  }, []);
  const title = here.at === "case" || here.at === "phone" ? "" : t(here.at);
  useEffect(() => {
    if (title) document.title = `${title}: limbgram`;
  }, [title]);
  if (here.at === "phone") return <PhoneScreen key={here.id} id={here.id} />;
  if (here.at === "case")
    return <CaseScreen key={here.id} id={here.id} step={here.step} helping={helping.value} onHelp={() => (helping.value = !helping.value)} />;
  return (
    <Shell place={here} head={null} helping={helping.value} onHelp={() => (helping.value = !helping.value)}>
      <WithNotices helping={helping.value} topic={here.at} onClose={() => (helping.value = false)}>
        {here.at === "cameras" ? <CameraScreen /> : here.at === "settings" ? <SettingsScreen /> : <CasesScreen />}
      </WithNotices>
    </Shell>
  );
}

/** What lies round a screen: help beside it, and what is wrong with the way to the program. */
function WithNotices({ children, helping, topic, onClose }: { children: preact.ComponentChildren; helping: boolean; topic: string; onClose: () => void }) {
  const waits = useWaiting();
  const cases = eachOnce(forgotten.value.map((one) => one.lane.split(" ")[0]));
  return (
    <div class={`around ${helping ? "with-help" : ""}`}>
      <div class="around-main">
        <div class="link-state" aria-live="polite">
          {link.value === "lost" && (
            <Notice tone="amber" title={t("lost")}>
              {t("lost.why")}
            </Notice>
          )}
          {link.value === "locked" && (
            <Notice tone="red" title={t("locked")}>
              {t("locked.why")}
            </Notice>
          )}
          {waits > 0 && link.value !== "lost" && (
            <Notice tone="plain" title={t("acts.wait", waits)}>
              {t("acts.wait.why")}
            </Notice>
          )}
          {forgotten.value.length > 0 && (
            <Notice
              tone="red"
              title={t("acts.forgotten", forgotten.value.length, eachOnce(forgotten.value.map((one) => one.by)))}
              action={<Button onClick={() => (forgotten.value = [])}>{t("close")}</Button>}
            >
              {t("acts.forgotten.why")} {cases && `${t("cases")}: ${cases}`}
            </Notice>
          )}
          {missed.value && (
            <Notice tone="red" title={t("acts.missed")} action={<Button onClick={() => (missed.value = null)}>{t("close")}</Button>}>
              {missed.value.message}
            </Notice>
          )}
        </div>
        {children}
      </div>
      {helping && <HelpPanel topic={topic} onClose={onClose} />}
    </div>
  );
}

/** Each once, in a row. */
const eachOnce = (names: readonly string[]): string => [...new Set(names)].filter(Boolean).join(", ");

/** How many acts wait for their answer, once that takes long. */
function useWaiting(): number {
  const late = useSignal(false);
  const count = pending.value.filter((one) => !isOfFiles(one)).length;
  useEffect(() => {
    late.value = false;
    const wait = setTimeout(() => (late.value = true), LATE_MS);
    return () => clearTimeout(wait);
  }, [count > 0]);
  return late.value ? count : 0;
}

function CaseScreen({ id, step, helping, onHelp }: { id: string; step: Page; helping: boolean; onHelp: () => void }) {
  const asked = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}", { params: { path: { case_id: id } } })), [id]);
  const changes = useSignal<Readonly<Record<string, number>>>({});
  const CaseStep = useLoaded(step, (wanted) => SCREENS[wanted]());
  useEffect(
    () =>
      listen(`/cases/${encodeURIComponent(id)}/events`, (changed) => {
        const counts = { ...changes.value };
        for (const subject of changed) counts[subject] = (counts[subject] ?? 0) + 1;
        changes.value = counts;
        void asked.again();
      }),
    [id],
  );
  const one = asked.value.value;
  const title = `${step === "compare" ? t("compare") : t(`step.${step}`)} ${id}: limbgram`;
  useEffect(() => {
    document.title = title;
  }, [title]);
  return (
    <Shell place={{ at: "case", id, step }} head={headOf(id, one)} helping={helping} onHelp={onHelp}>
      <WithNotices helping={helping} topic={step} onClose={onHelp}>
        {one && one.unreadable.length > 0 && <Unreadable id={id} found={one.unreadable} again={asked.again} />}
        {asked.refused.value && !one ? (
          <main class="cases" id="content" tabIndex={-1}>
            <Refusal
              refused={asked.refused.value}
              action={
                <a class="btn" href={href.cases}>
                  {t("back.to.cases")}
                </a>
              }
            />
          </main>
        ) : one && CaseStep ? (
          <CaseStep openCase={{ id, info: one, changes: changes.value, again: asked.again }} />
        ) : (
          <main id="content" class="waiting" aria-busy="true">
            <span class="unseen">{t("loading")}</span>
          </main>
        )}
      </WithNotices>
    </Shell>
  );
}

/** Files of people's work that cannot be read: nothing is written over them until somebody begins them anew. */
function Unreadable({ id, found, again }: { id: string; found: readonly Finding[]; again: () => Promise<unknown> }) {
  const act = useAct();
  const begin = () =>
    act.run(async () => {
      await perform(id, "post", "/api/v1/cases/{case_id}/set-aside", { params: { path: { case_id: id } } });
      await again();
    });
  return (
    <>
      <Notice tone="red" title={t("unreadable")} action={<Button onClick={() => void begin()}>{t("unreadable.begin")}</Button>}>
        {found.map((one) => (
          <p key={told(one)}>{told(one)}</p>
        ))}
        <p class="small soft">{t("unreadable.kept")}</p>
      </Notice>
      <Refusal refused={act.refused.value} />
    </>
  );
}
