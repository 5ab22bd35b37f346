/** The axes: set from the places, looked at, turned round, or turned by hand. */
import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Vector3 } from "three";

import type { Schemas } from "../../api/client";
import { type AxesTurn, STILL, turned } from "../../geometry/axes-turn";
import { type Rigid, type Vec3, add, scale, sub, xyz } from "../../geometry/vectors";
import { sided } from "../../limb-kinds";
import { perform } from "../../state/acts";
import { t } from "../../texts";
import type { Viewer } from "../../viewer/viewer";
import type { Placing } from "./placing";
import type { Subject } from "./subject";

export interface Axes {
  /** Of the joint: as stated, else that with which the axes were set last. */
  readonly flexion_deg: Signal<number>;
  /** Whether up is down. */
  readonly flipped: Signal<boolean>;
  /** Towards whoever looked, where that is the front. */
  readonly front: Signal<Vec3 | null>;
  /** What a hand turned since the axes were set; not kept yet. */
  readonly byHand: Signal<AxesTurn>;
  /** Whether front or proximal end were chosen anew since they were set. */
  readonly chosenAnew: boolean;
  /** What lacks before they can be set, in words. */
  readonly lacks: string | null;
  readonly set: () => void;
  /** Keep what the hand turned: the axes as they are shown are stated to the server. */
  readonly keepByHand: () => void;
  /** What a hand does to the handles of the axes. */
  readonly drag: (by: AxesTurn, done: boolean) => void;
}

export function useAxes(subject: Subject, { places, known }: Placing): Axes {
  const { limb, aligned, kind, side } = subject;
  const kept_deg = limb?.reply.flexion_deg ?? 0;
  const flexion_deg = useSignal(kept_deg);
  useEffect(() => void (flexion_deg.value = kept_deg), [kept_deg]);
  const flipped = useSignal(false);
  const front = useSignal<Vec3 | null>(null);
  const byHand = useSignal<AxesTurn>(STILL);
  /** The front as it was when they were set. */
  const frontSet = useSignal<Vec3 | null>(null);
  /** What was turned when the hand took a handle. */
  const from = useRef<AxesTurn | null>(null);
  const sideLacks = (!side || side === "none") && sided(kind);
  const facing = places.some((one) => known.find((k) => k.name === one.name && k.facing !== "none"));
  const lacks = !kind ? t("align.kind.first") : sideLacks ? t("align.side.first") : !facing && !front.value ? t("align.places.first") : null;

  const state = async (body: Schemas["Align"], afterwards: () => void) => {
    const { openCase, asked, take } = subject;
    const path = { case_id: openCase.id };
    await perform(
      openCase.id,
      "post",
      "/api/v1/cases/{case_id}/limb/align",
      { params: { path }, body },
      { done: take, again: asked.again, askedSince: asked.askedSince },
    );
    afterwards();
    await openCase.again();
    await asked.again();
  };
  const set = () =>
    void subject.act.run(async () => {
      if (sideLacks) return;
      const up = limb && scale(axisOf(limb.frame, aligned ? flexion_deg.value : 0), flipped.value ? -1 : 1);
      const body: Schemas["Align"] = {
        side: side ?? "none",
        kind,
        axis: "fit",
        proximal: up && [...up],
        anterior: front.value && [...front.value],
        flexion_deg: flexion_deg.value,
      };
      await state(body, () => {
        subject.saved.value = t("align.done");
        flipped.value = false;
        frontSet.value = front.value;
        byHand.value = STILL;
      });
    });
  const keepByHand = () =>
    void subject.act.run(async () => {
      if (!limb) return;
      const [, forwards, up] = turned(limb.frame, byHand.value).rotation;
      await state({ side: side ?? "none", kind, axis: [...up], anterior: [...forwards], flexion_deg: 0 }, () => {
        byHand.value = STILL;
        subject.saved.value = t("align.by.hand.kept");
      });
    });
  const drag = (by: AxesTurn, done: boolean) => {
    const begun = (from.current ??= byHand.value);
    byHand.value = {
      turn_deg: tenth(begun.turn_deg + by.turn_deg),
      flex_deg: tenth(begun.flex_deg + by.flex_deg),
      lean_deg: tenth(begun.lean_deg + by.lean_deg),
    };
    if (done) from.current = null;
  };
  const chosenAnew = flipped.value || front.value !== frontSet.value;
  return { flexion_deg, flipped, front, byHand, chosenAnew, lacks, set, keepByHand, drag };
}

/** From the limb towards whoever looks, in the mesh's frame; null where there is no limb. */
export function towardsViewer(viewer: Viewer | null): Vec3 | null {
  if (!viewer?.surface) return null;
  return sub(xyz(viewer.surface.toMesh(viewer.axes().back)), xyz(viewer.surface.toMesh(new Vector3())));
}

/** The long axis that is shown, proximally, in the mesh's frame: the flexion with which it was set takes its top backwards. */
function axisOf({ rotation: [, forwards, up] }: Rigid, flexion_deg: number): Vec3 {
  const angle = (flexion_deg * Math.PI) / 180;
  return add(scale(up, Math.cos(angle)), scale(forwards, -Math.sin(angle)));
}

const tenth = (deg: number) => Math.round(10 * deg) / 10;
