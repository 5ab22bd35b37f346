/** The photos of a case with what the coach said of them, and the acts: add, check, compute. */
import { useEffect, useMemo, useRef } from "preact/hooks";

import { type Schemas, answerOf, api } from "../../api/client";
import { newOffer, perform } from "../../state/acts";
import { type Query, useAct, useQuery } from "../../state/requests";
import { type Choices, boardOf, choicesOf, jobOf, keepChoices, rulerOf } from "../../state/choices";
import { go, href } from "../../state/route";
import { type Outstanding, outstanding, send } from "../../state/uploads";
import type { OpenCase } from "../open-case";
import { goes } from "./banner-words";

/** Photos come one after the other: they are checked once they rest. */
const REST_MS = 600;
/** With fewer the server checks nothing. */
export const LEAST_PHOTOS = 3;

export interface Capture {
  readonly openCase: OpenCase;
  readonly photos: Query<Schemas["Photos"]>;
  readonly check: Query<Schemas["Check"]>;
  readonly cameras: readonly Schemas["CameraReply"][];
  readonly choices: Choices;
  /** Held by the server. */
  readonly here: readonly Schemas["Photo"][];
  /** How many of them can be used; of several files of one shot one is. */
  readonly count: number;
  /** Not held by it: on their way, or refused. */
  readonly coming: Outstanding;
  /** Whether the photos as they are now do. */
  readonly goes: boolean;
  readonly act: ReturnType<typeof useAct>;
  readonly add: (files: readonly File[]) => void;
  /** Something came or went. */
  readonly arrived: () => void;
  readonly askCheck: () => void;
  readonly choose: (part: Partial<Choices>) => void;
  readonly compute: () => void;
}

export function useCapture(openCase: OpenCase): Capture {
  const path = { params: { path: { case_id: openCase.id } } };
  const photos = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/photos", path)), [openCase.id, openCase.changes.photos]);
  const check = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/check", path)), [openCase.id, openCase.changes.check, openCase.changes.photos]);
  const cameras = useQuery(() => answerOf(api.GET("/api/v1/cameras", {})), [openCase.changes.photos]);
  const act = useAct();
  /** Of the run that is asked for: pressed twice it is one. */
  const run = useMemo(newOffer, []);
  const wait = useRef(0);
  const choices = choicesOf(openCase.id);
  const list = photos.value.value;
  const said = check.value.value;
  const here = list?.photos.filter((one) => one.state !== "arriving") ?? [];
  const count = list?.here ?? 0;
  const coming = outstanding(openCase.id, here);

  const askCheck = () =>
    void act.run(async () => {
      const { cameras: ids } = choicesOf(openCase.id);
      await perform(
        openCase.id,
        "post",
        "/api/v1/cases/{case_id}/check",
        { ...path, body: { cameras: [...ids], board: boardOf(openCase.id) } },
        { done: check.put, again: check.again, askedSince: check.askedSince, lane: `${openCase.id} check` },
      );
    });
  const checkSoon = () => {
    clearTimeout(wait.current);
    wait.current = window.setTimeout(askCheck, REST_MS);
  };
  const arrived = () => {
    void photos.again();
    checkSoon();
  };
  const add = (files: readonly File[]) => {
    if (files.length) send(openCase.id, files, arrived);
  };
  const looked = useRef(0);
  useEffect(() => {
    const started = !["empty", "photos"].includes(openCase.info.state);
    if (!list || list.here < LEAST_PHOTOS || started || !said || said.current || said.state === "running" || looked.current === list.here) return;
    looked.current = list.here;
    checkSoon();
  }, [list?.here, said?.state, said?.current]);
  useEffect(() => () => clearTimeout(wait.current), []);

  const choose = (part: Partial<Choices>) => {
    const asks = () => JSON.stringify([boardOf(openCase.id), choicesOf(openCase.id).cameras]);
    const before = asks();
    keepChoices(openCase.id, part);
    if (count >= LEAST_PHOTOS && asks() !== before) askCheck();
  };
  const compute = () =>
    void act.run(async () => {
      keepChoices(openCase.id, { ruler_mm: rulerOf(choices) });
      const body = jobOf(openCase.id);
      await perform(openCase.id, "post", "/api/v1/cases/{case_id}/job", { ...path, body }, { id: run.idOf(body) });
      run.over();
      go(href.step(openCase.id, "result"));
    });

  return {
    openCase,
    photos,
    check,
    cameras: cameras.value.value ?? [],
    choices,
    here,
    count,
    coming,
    goes: goes(said),
    act,
    add,
    arrived,
    askCheck,
    choose,
    compute,
  };
}
