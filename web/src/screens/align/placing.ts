/** Places as they are set, dragged, guessed, left out and taken away. */
import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Vector3 } from "three";

import { type Schemas, answerOf, api } from "../../api/client";
import { distance, xyz } from "../../geometry/vectors";
import { perform, pendingAt } from "../../state/acts";
import { type Query, useQuery } from "../../state/requests";
import { nameOfSticker, rememberSticker } from "../../state/stickers";
import { t } from "../../texts";
import { term } from "../../words";
import { type Known, type Offered, type Place, SAME_MM, nextAfter, offeredOf, orderOf, withPending } from "./places";
import type { Subject } from "./subject";
import { type Visit, useVisit } from "./visit";

/** How a place was found that no hand placed. */
export type Told = Pick<Schemas["PlaceMark"], "placed" | "sigma_mm">;

const PLACE = "/api/v1/cases/{case_id}/limb/places/{name}";

export interface Placing {
  readonly places: readonly Place[];
  readonly known: readonly Known[];
  /** All names, in the order of the list. */
  readonly order: readonly string[];
  readonly offered: readonly Offered[];
  /** What the places of an earlier visit tell, and the case that it was. */
  readonly visit: Visit;
  /** Marks that the photos show, before anything is set. */
  readonly marks: readonly Schemas["Mark"][];
  readonly namesRefused: Query<unknown>["refused"];
  /** The name that the next press on the limb sets. */
  readonly armed: Signal<string | null>;
  readonly chosen: Signal<string | null>;
  /** A place while it is dragged. */
  readonly held: Signal<{ readonly name: string; readonly point: Vector3 } | null>;
  /** Names that are left out. */
  readonly leftOut: Signal<ReadonlySet<string>>;
  readonly put: (name: string, point: Vector3, told?: Told) => void;
  readonly remove: (name: string) => void;
  readonly after: (name: string) => string | null;
}

export function usePlacing(subject: Subject): Placing {
  const { openCase, limb, asked, kind, aligned, act, saved, take } = subject;
  const path = { params: { path: { case_id: openCase.id } } };
  const armed = useSignal<string | null>(null);
  const chosen = useSignal<string | null>(null);
  const held = useSignal<{ name: string; point: Vector3 } | null>(null);
  const leftOut = useSignal<ReadonlySet<string>>(new Set());
  const names = useQuery(async () => (kind ? await answerOf(api.GET("/api/v1/templates/names/{kind}", { params: { path: { kind } } })) : []), [kind]);
  const marks = useQuery(
    async () => (limb && !limb.reply.aligned && limb.reply.places.length === 0 ? await answerOf(api.GET("/api/v1/cases/{case_id}/limb/marks", path)) : []),
    [limb?.reply.sha256],
  );
  const guesses = useQuery(
    async () => (limb ? await answerOf(api.GET("/api/v1/cases/{case_id}/limb/guesses", path)) : null),
    [limb?.reply.sha256, kind, limb?.reply.aligned],
  );

  const places = withPending(limb?.reply.places ?? [], pendingAt(openCase.id, PLACE));
  const known = names.value.value ?? [];
  const order = orderOf(known, places);
  const visit = useVisit(subject);
  const told = visit.asked.value.value?.places ?? [];
  const offered = useMemo(() => {
    const own = guesses.value.value?.places ?? [];
    return offeredOf([...own, ...told.filter((one) => !own.some((guess) => guess.name === one.name))], places, nameOfSticker);
  }, [guesses.value.value, told, places]);

  // The first name is armed at once: one press on the limb is all that is asked.
  const first = order.find((name) => !places.some((one) => one.name === name) && !leftOut.value.has(name)) ?? null;
  useEffect(() => {
    if (limb && !aligned && armed.value === null && places.length === 0 && first) armed.value = first;
  }, [limb, first]);

  const put = (name: string, point: Vector3, found: Told = { placed: "click" }) =>
    void act.run(async () => {
      chosen.value = name;
      const [x, y, z] = xyz(point);
      const kept = perform(
        openCase.id,
        "put",
        PLACE,
        { params: { path: { case_id: openCase.id, name } }, body: { ...found, position_mm: [x, y, z] } },
        { done: take, again: asked.again, askedSince: asked.askedSince },
      );
      if (held.value?.name === name) held.value = null; // what is on its way to the server is shown by itself
      await kept;
      const sticker = offered.find((one) => one.sticker !== null && distance(one.at, [x, y, z]) < SAME_MM)?.sticker;
      if (sticker !== null && sticker !== undefined) rememberSticker(sticker, name);
      saved.value = t("align.placed", term(name));
    });
  const remove = (name: string) =>
    void act.run(async () => {
      if (chosen.value === name) chosen.value = null;
      await perform(
        openCase.id,
        "delete",
        PLACE,
        { params: { path: { case_id: openCase.id, name } } },
        { done: take, again: asked.again, askedSince: asked.askedSince },
      );
    });
  const after = (name: string) => nextAfter(name, order, places, leftOut.value);

  return {
    places,
    known,
    order,
    offered,
    visit,
    marks: marks.value.value ?? [],
    namesRefused: names.refused,
    armed,
    chosen,
    held,
    leftOut,
    put,
    remove,
    after,
  };
}
