/** What is to be done next in a case, and where. */
import type { Schemas } from "../../api/client";
import { href } from "../../state/route";
import { t } from "../../texts";

export function nextOf(one: Schemas["Case"]): { text: string; to: string } {
  const to = (step: Schemas["Case"]["next"]) => href.step(one.id, step);
  if (one.state === "computing" || one.state === "held") return { text: t("next.watch"), to: to("result") };
  if (one.state === "refused" || one.state === "failed" || one.state === "interrupted") return { text: t("next.todo"), to: to("result") };
  if (one.state === "empty" || one.state === "photos" || one.state === "cancelled") return { text: t("next.capture"), to: to("capture") };
  if (one.verdict && one.verdict.light !== "green" && one.next === "align") return { text: t("next.todo"), to: to("result") };
  if (one.next === "record") return { text: t("next.record"), to: to("record") };
  return { text: t("next.go", t(`step.${one.next}`)), to: to(one.next) };
}
