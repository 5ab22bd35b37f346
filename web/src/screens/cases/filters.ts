/** Which cases the list shows. */
import type { Schemas } from "../../api/client";

export type Filter = "all" | "work" | "sent" | "archive";

export const FILTERS: readonly Filter[] = ["all", "work", "sent", "archive"];

export function membersOf(all: readonly Schemas["Case"][]): Record<Filter, Schemas["Case"][]> {
  const sent = (one: Schemas["Case"]) => one.steps.some((step) => step.name === "send" && step.state === "done");
  return {
    all: all.filter((one) => !one.archived),
    work: all.filter((one) => !one.archived && !sent(one)),
    sent: all.filter((one) => !one.archived && sent(one)),
    archive: all.filter((one) => one.archived),
  };
}
