/** The file that is asked for: its kind, its side and who signs for it; the server writes it and reads it back. */
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

import { type Schemas, answerOf, api } from "../../api/client";
import { usualOf } from "../../formats";
import { sided } from "../../limb-kinds";
import { perform } from "../../state/acts";
import { useAct, useQuery } from "../../state/requests";
import { type TextKey, t } from "../../texts";
import type { OpenCase } from "../open-case";

/** What a person is asked of a kind of file; its unit, its limits and what it is usually, the server says. */
export const ASKED: Readonly<Record<string, readonly Asked[]>> = {
  aop: [
    { name: "spokes", label: "send.spokes", step: 10, decimals: 0 },
    { name: "spacing_mm", label: "send.spacing", step: 0.5, decimals: 2 },
    { name: "distal_slices", label: "send.distal", step: 2, decimals: 0 },
  ],
  dxf: [{ name: "spacing_mm", label: "send.sections", step: 5, decimals: 1 }],
  gcode: [{ name: "tool_diameter_mm", label: "send.tool", step: 1, decimals: 1 }],
};

interface Asked {
  readonly name: string;
  readonly label: TextKey;
  readonly step: number;
  readonly decimals: number;
}

type Side = "left" | "right";

export type Export = ReturnType<typeof useExport>;

/** @param tag - Of the shape as it is now; null until that is known. */
export function useExport(openCase: OpenCase, tag: string | null) {
  const path = { params: { path: { case_id: openCase.id } } };
  const kind = useSignal("aop");
  const side = useSignal<Side | null>(null);
  const held = useSignal(false);
  const signer = useSignal("");
  /** What was entered, by kind of file and field; the rest is as usual. */
  const entered = useSignal<Readonly<Record<string, Record<string, number>>>>({});
  const written = useSignal<Schemas["ExportedFile"] | null>(null);
  const act = useAct();
  /** The file that is asked for now, and no other, is shown and saved. */
  const wanted = useRef<Schemas["NewExport"] | null>(null);
  const before = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/exports", path)), [openCase.id, openCase.changes.work]);
  const known = openCase.info.side;
  const red = openCase.info.verdict?.light === "red";
  const other = side.value !== null && (known === "left" || known === "right") && known !== side.value;
  const torso = !sided(openCase.info.kind);

  const write = (next: { kind?: string; side?: Side | null } = {}) => {
    const chosen = { kind: next.kind ?? kind.value, side: next.side === undefined ? side.value : next.side };
    kind.value = chosen.kind;
    side.value = chosen.side;
    held.value = false;
    written.value = null;
    wanted.current = null;
    const contradicts = chosen.side !== null && (known === "left" || known === "right") && known !== chosen.side;
    if ((!chosen.side && !torso) || contradicts || (red && !signer.value.trim())) return;
    wanted.current = {
      kind: chosen.kind,
      side: torso ? "none" : (chosen.side as Side),
      signed_by: signer.value.trim(),
      how: howOf(chosen.kind),
    };
    if (!act.busy.value) void act.run(writeWanted).then(() => before.again());
  };
  // A change in another window made another shape: its file is written anew, and looked at anew.
  const last = useRef<string | null>(null);
  useEffect(() => {
    if (last.current && tag && last.current !== tag && wanted.current) write();
    last.current = tag ?? last.current;
  }, [tag]);
  /** What the receiver expects of a kind, as it stands in its fields. */
  const howOf = (one: string): NonNullable<Schemas["NewExport"]["how"]> => Object.fromEntries((ASKED[one] ?? []).map(({ name }) => [name, valueOf(one, name)]));
  const valueOf = (one: string, name: string): number | undefined => entered.value[one]?.[name] ?? usualOf(one, name);
  const enter = (one: string, name: string, value: number) => {
    entered.value = { ...entered.value, [one]: { ...entered.value[one], [name]: value } };
    write();
  };
  /** One file after the other; what was wanted before and is not any more is not shown. */
  const writeWanted = async () => {
    for (let body = wanted.current; body;) {
      const made = await perform(openCase.id, "post", "/api/v1/cases/{case_id}/exports", { ...path, body }, { lane: `${openCase.id} files` }).catch(
        (error: unknown) => {
          if (wanted.current === body) throw error;
          return null; // refused, and not wanted any more
        },
      );
      if (wanted.current === body) {
        written.value = made;
        break;
      }
      body = wanted.current;
    }
  };
  /** Why the file cannot be saved yet; null where it can. */
  const off = (): string | null => {
    if (act.busy.value) return t("send.writing");
    if (!side.value && !torso) return t("send.off.side");
    if (other) return t("send.off.contradiction");
    if (red && !signer.value.trim()) return t("send.off.red");
    if (!written.value) return t("send.off.none");
    return held.value ? null : t("send.off.picture");
  };
  return { kind, side, held, signer, written, act, before, known, red, other, torso, write, valueOf, enter, off };
}
