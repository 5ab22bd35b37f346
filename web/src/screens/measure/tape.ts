/** The readings of the tape: kept by the server, judged by it, and why one was not kept. */
import { useSignal } from "@preact/signals";

import { Refused, answerOf, api } from "../../api/client";
import { perform, pendingAt } from "../../state/acts";
import { useAct, useQuery } from "../../state/requests";
import { go, href } from "../../state/route";
import { t } from "../../texts";
import { heightIs, judged, withPending } from "../readings";
import type { OpenCase } from "../open-case";
import type { Measured } from "./measured";

const TAPE = "/api/v1/cases/{case_id}/tape";

interface NotKept {
  readonly girth_mm: number | null;
  readonly refused: Refused;
}

export type Tape = ReturnType<typeof useTape>;

export function useTape(openCase: OpenCase, { measures }: Measured) {
  const path = { params: { path: { case_id: openCase.id } } };
  const act = useAct();
  const kept = useQuery(() => answerOf(api.GET(TAPE, path)), [openCase.id, openCase.changes.work]);
  /** Why a reading was not kept, by its height. */
  const wrong = useSignal<ReadonlyMap<number, NotKept>>(new Map());
  const readings = judged(withPending(kept.value.value ?? [], pendingAt(openCase.id, TAPE)), measures.busy.value ? [] : (measures.value.value?.tape ?? []));
  const waits = readings.some((one) => one.verdict === null);
  const conflicts = readings.filter((one) => one.verdict?.conflict);

  const said = (height_mm: number, refused: Refused | null, girth_mm: number | null) => {
    const next = new Map([...wrong.value].filter(([height]) => !heightIs(height, height_mm)));
    if (refused) next.set(height_mm, { girth_mm, refused });
    wrong.value = next;
  };
  const keep = (height_mm: number, girth_mm: number | null) =>
    void act.run(async () => {
      said(height_mm, null, girth_mm);
      try {
        await perform(
          openCase.id,
          "patch",
          TAPE,
          { ...path, body: { height_mm, girth_mm } },
          { done: kept.put, again: kept.again, askedSince: kept.askedSince },
        );
      } catch (error) {
        if (error instanceof Refused) said(height_mm, error, girth_mm);
        throw error;
      }
      await measures.again();
    });
  /** Going on in spite of a conflict is an act: the record tells it, with its time. */
  const goOn = () =>
    act.run(async () => {
      for (const { height_mm, girth_mm, verdict } of conflicts)
        if (!verdict?.accepted) await perform(openCase.id, "post", "/api/v1/cases/{case_id}/tape/accept", { ...path, body: { height_mm, girth_mm } });
      go(href.step(openCase.id, "rectify"));
    });
  const comparing = t(measures.refused.value ? "measure.compared.not" : "measure.comparing");
  const refused = (wrong.value.size ? null : act.refused.value) ?? kept.refused.value;
  return { act, readings, waits, comparing, conflicts, refused, wrong: wrong.value, keep, goOn };
}
