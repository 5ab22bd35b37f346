/** The limb that is aligned, and what every act on it needs. */
import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useRef } from "preact/hooks";

import type { Schemas } from "../../api/client";
import { useAct } from "../../state/requests";
import type { Viewer } from "../../viewer/viewer";
import { type Limb, useLimb } from "../limb";
import type { OpenCase } from "../open-case";

export interface Subject {
  readonly openCase: OpenCase;
  readonly viewer: RefObject<Viewer | null>;
  readonly limb: Limb | null;
  readonly asked: ReturnType<typeof useLimb>["asked"];
  /** As the case says them; a case that was aligned elsewhere says nothing. */
  readonly kind: Schemas["Align"]["kind"] | null;
  readonly side: Schemas["Align"]["side"] | null;
  readonly aligned: boolean;
  /** What was done last, in words. */
  readonly saved: Signal<string>;
  readonly act: ReturnType<typeof useAct>;
  /** Take the limb that an act answered. */
  readonly take: (reply: Schemas["LimbReply"]) => void;
}

export function useSubject(openCase: OpenCase): Subject {
  const { limb, asked } = useLimb(openCase, "scan");
  const viewer = useRef<Viewer | null>(null);
  const saved = useSignal("");
  const act = useAct();
  const take = (reply: Schemas["LimbReply"]) => {
    const before = asked.value.value;
    if (before) asked.put({ ...before, reply });
  };
  const kind = openCase.info.kind ?? limb?.reply.kind ?? null;
  const side = openCase.info.side ?? limb?.reply.side ?? null;
  return { openCase, viewer, limb, asked, kind, side, aligned: limb?.reply.aligned ?? false, saved, act, take };
}
