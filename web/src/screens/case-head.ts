/** What the frame round a screen shows of a case: what it is, and how each step stands. */
import type { Schemas } from "../api/client";
import type { CaseHead, StepState } from "../design/shell";
import { kindName } from "../limb-kinds";
import { STEPS, type Step } from "../state/route";
import { t } from "../texts";

type Case = Schemas["Case"];

export function headOf(id: string, one: Case | null): CaseHead {
  const later: StepState = { state: "later", note: "", needs: "" };
  const steps = Object.fromEntries(STEPS.map((step) => [step, later])) as Record<Step, StepState>;
  for (const step of one?.steps ?? []) steps[step.name] = stateOf(step, one);
  return { id, kind: one ? (one.sample ? t("kind.sample") : kindName(one.kind)) : "", side: one?.side, steps };
}

function stateOf(step: Schemas["Step"], one: Case | null): StepState {
  if (step.state === "locked") return { state: "later", note: "", needs: t("step.needs", t(`step.${neededBy(step.name, one?.steps ?? [])}`)) };
  const check = step.state === "check";
  return { state: step.state === "done" ? "done" : "open", note: check ? t("step.check") : lineOf(step, one), needs: "", warn: check };
}

/** The step that a locked one waits for: the last before it that is not locked itself. */
function neededBy(locked: Step, steps: readonly Schemas["Step"][]): Step {
  const before = steps.slice(
    0,
    steps.findIndex((one) => one.name === locked),
  );
  return before.findLast((one) => one.state !== "locked")?.name ?? "capture";
}

/** What a step has brought. */
function lineOf({ name, count, front }: Schemas["Step"], one: Case | null): string {
  if (name === "result") return one?.verdict ? t(`verdict.${one.verdict.light}`) : t("result.none");
  if (name === "record") return "";
  return t(name === "align" && front ? "state.front" : LINES[name], count);
}

const LINES = { capture: "state.photos", align: "state.places", measure: "state.tapes", rectify: "state.edits", send: "state.files" } as const;
