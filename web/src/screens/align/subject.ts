/** The limb that is aligned, and what every act on it needs. */
import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useRef } from "preact/hooks";

import type { Schemas } from "../../api/client";
import { useAct } from "../../state/asked";
import type { Viewer } from "../../viewer/viewer";
import { type Limb, useLimb } from "../limb";
import type { Room } from "../room";

export interface Subject {
  readonly room: Room;
  readonly viewer: RefObject<Viewer | null>;
  readonly limb: Limb | null;
  readonly asked: ReturnType<typeof useLimb>["asked"];
  readonly kind: Schemas["Align"]["kind"] | null;
  readonly side: Schemas["Align"]["side"] | null;
  readonly aligned: boolean;
  /** What was done last, in words. */
  readonly saved: Signal<string>;
  readonly act: ReturnType<typeof useAct>;
  /** Take the limb that an act answered. */
  readonly take: (reply: Schemas["LimbReply"]) => void;
}

export function useSubject(room: Room): Subject {
  const { limb, asked } = useLimb(room, "scan");
  const viewer = useRef<Viewer | null>(null);
  const saved = useSignal("");
  const act = useAct();
  const take = (reply: Schemas["LimbReply"]) => {
    const before = asked.value.value;
    if (before) asked.put({ ...before, reply });
  };
  const kind = limb?.reply.kind ?? room.info.kind ?? null;
  const side = limb?.reply.side ?? room.info.side ?? null;
  return { room, viewer, limb, asked, kind, side, aligned: limb?.reply.aligned ?? false, saved, act, take };
}
