/** What can be done to a case in the list: change, clear, delete; what lies in it is shown before. */
import { useSignal } from "@preact/signals";

import { type Schemas, answerOf, api } from "../../api/client";
import { perform } from "../../state/acts";
import { useAct } from "../../state/requests";

/** What is asked of the person before it is done. */
export type Doing = "delete" | "rename" | "clear";

export type ActsOfCase = ReturnType<typeof useActsOfCase>;

/** @param onChange - Called after each act. */
export function useActsOfCase(id: string, onChange: () => void) {
  const doing = useSignal<Doing | null>(null);
  const act = useAct();
  const held = useSignal<Schemas["Held"][]>([]);
  const path = { params: { path: { case_id: id } } };
  const change = (body: Schemas["CaseChange"]) =>
    act.run(async () => {
      await perform(id, "patch", "/api/v1/cases/{case_id}", { ...path, body });
      doing.value = null;
      onChange();
    });
  const ask = (what: "delete" | "clear") =>
    act.run(async () => {
      held.value = await answerOf(api.GET("/api/v1/cases/{case_id}/contents", path));
      doing.value = what;
    });
  const remove = () =>
    act.run(async () => {
      await perform(id, "delete", "/api/v1/cases/{case_id}", path);
      onChange();
    });
  const clear = () =>
    act.run(async () => {
      await perform(id, "post", "/api/v1/cases/{case_id}/clear", path);
      doing.value = null;
      onChange();
    });
  return { doing, refused: act.refused, held, change, ask, remove, clear };
}
