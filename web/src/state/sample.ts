/** A sample case: made by the server where it offers that. */
import { ROOT, Refused, type Schemas, note, refusedBy } from "../api/client";
import { t } from "../texts";

export async function makeSample(): Promise<Schemas["Case"]> {
  const response = await fetch(`${ROOT}/cases/sample`, { method: "POST", credentials: "same-origin" }).catch(() => null);
  if (!response) throw new Refused("Lost", t("lost"), 0);
  note(response.status);
  const body: unknown = await response.json().catch(() => null);
  if (!response.ok) throw refusedBy(response.status, body);
  return body as Schemas["Case"];
}
