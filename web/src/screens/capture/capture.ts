/** The photos of a case with what the coach said of them, and the acts: add, check, compute. */
import { useEffect, useMemo, useRef } from "preact/hooks";

import { type Schemas, api, taken } from "../../api/client";
import { newOffer, perform } from "../../state/acts";
import { type Asked, useAct, useAsked } from "../../state/asked";
import { type Choices, boardOf, choicesOf, jobOf, keepChoices, rulerOf } from "../../state/choices";
import { go, href } from "../../state/route";
import { type Outstanding, outstanding, send } from "../../state/uploads";
import type { Room } from "../room";
import { goes } from "./banner-words";

/** Photos come one after the other: they are checked once they rest. */
const REST_MS = 600;
/** With fewer the server checks nothing. */
export const LEAST_PHOTOS = 3;

export interface Capture {
  readonly room: Room;
  readonly photos: Asked<Schemas["Photos"]>;
  readonly check: Asked<Schemas["Check"]>;
  readonly cameras: readonly Schemas["CameraReply"][];
  readonly choices: Choices;
  /** Held by the server. */
  readonly here: readonly Schemas["Photo"][];
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

export function useCapture(room: Room): Capture {
  const path = { params: { path: { case_id: room.id } } };
  const photos = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/photos", path)), [room.id, room.news.photos]);
  const check = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/check", path)), [room.id, room.news.check, room.news.photos]);
  const cameras = useAsked(() => taken(api.GET("/api/v1/cameras", {})), [room.news.photos]);
  const act = useAct();
  /** Of the run that is asked for: pressed twice it is one. */
  const run = useMemo(newOffer, []);
  const wait = useRef(0);
  const choices = choicesOf(room.id);
  const list = photos.value.value;
  const said = check.value.value;
  const here = list?.photos.filter((one) => one.state !== "arriving") ?? [];
  const coming = outstanding(room.id, here);

  const askCheck = () =>
    void act.run(async () => {
      const { cameras: ids } = choicesOf(room.id);
      await perform(
        room.id,
        "post",
        "/api/v1/cases/{case_id}/check",
        { ...path, body: { cameras: [...ids], board: boardOf(room.id) } },
        { done: check.put, again: check.again, askedSince: check.askedSince, lane: `${room.id} check` },
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
    if (files.length) send(room.id, files, arrived);
  };
  const looked = useRef(0);
  useEffect(() => {
    const started = !["empty", "photos"].includes(room.info.state);
    if (!list || list.here < LEAST_PHOTOS || started || !said || said.current || said.state === "running" || looked.current === list.here) return;
    looked.current = list.here;
    checkSoon();
  }, [list?.here, said?.state, said?.current]);
  useEffect(() => () => clearTimeout(wait.current), []);

  const choose = (part: Partial<Choices>) => {
    const asks = () => JSON.stringify([boardOf(room.id), choicesOf(room.id).cameras]);
    const before = asks();
    keepChoices(room.id, part);
    if (here.length >= LEAST_PHOTOS && asks() !== before) askCheck();
  };
  const compute = () =>
    void act.run(async () => {
      keepChoices(room.id, { ruler_mm: rulerOf(choices) });
      const body = jobOf(room.id);
      await perform(room.id, "post", "/api/v1/cases/{case_id}/job", { ...path, body }, { id: run.idOf(body) });
      run.over();
      go(href.step(room.id, "result"));
    });

  return { room, photos, check, cameras: cameras.value.value ?? [], choices, here, coming, goes: goes(said), act, add, arrived, askCheck, choose, compute };
}
