/** The limb of a case as the working screens need it: what the server knows of it, and its surface. */
import { useMemo } from "preact/hooks";

import { type Schemas, answerOf, api } from "../api/client";
import type { Rigid, Vec3 } from "../geometry/vectors";
import { type Query, useQuery } from "../state/requests";
import { type Fetched, fetchSurface, frameOf } from "../state/shapes";
import type { OpenCase } from "./open-case";

export interface Limb {
  readonly reply: Schemas["LimbReply"];
  readonly fetched: Fetched;
  readonly frame: Rigid;
}

export function useLimb(
  openCase: OpenCase,
  of: "scan" | "rectified",
): { limb: Limb | null; asked: Query<{ reply: Schemas["LimbReply"]; fetched: Fetched; front: Vec3 | undefined }> } {
  const path = { params: { path: { case_id: openCase.id } } };
  const asked = useQuery(async () => {
    // One after the other: the first of them makes the server take the surface in.
    const reply = await answerOf(api.GET("/api/v1/cases/{case_id}/limb", path));
    const fetched = await fetchSurface(openCase.id, of);
    const front = reply.aligned ? undefined : await frontGuess(openCase.id);
    return { reply, fetched, front };
  }, [openCase.id, openCase.changes.work, openCase.info.state, of]);
  const value = asked.value.value;
  const limb = useMemo(
    () => (value ? { reply: value.reply, fetched: value.fetched, frame: frameOf(value.reply, value.fetched.data, value.front) } : null),
    [value],
  );
  return { limb, asked };
}

/** Towards the first photo: whoever photographs begins in front more often than not. It is a guess. */
async function frontGuess(caseId: string): Promise<Vec3 | undefined> {
  const { data } = await api.GET("/api/v1/cases/{case_id}/job/cameras", { params: { path: { case_id: caseId } } });
  const first = data?.[0];
  return first ? [-first.forward[0], -first.forward[1], -first.forward[2]] : undefined;
}
