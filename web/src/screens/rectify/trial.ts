/** What the server says an edit would do; its answer takes the place of this page's preview. */
import { type Signal, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";

import { changedBy, decodeBlocks } from "../../api/blocks";
import { Refused, type Schemas, bytesOf } from "../../api/client";
import { changedDifferences } from "../../geometry/differences";
import type { Surface, SurfaceData } from "../../viewer/surface";
import type { Viewer } from "../../viewer/viewer";
import type { Base } from "./base";
import type { EditBody } from "./draft";

export interface Tried {
  readonly surface: SurfaceData;
  readonly values: Float32Array;
  readonly line: Schemas["LineReply"] | null;
  /** The edit that was asked for. */
  readonly body: EditBody;
}

export interface Trial {
  readonly tried: Signal<Tried | null>;
  readonly waits: Signal<boolean>;
  readonly refused: Signal<Refused | null>;
  readonly ask: (body: EditBody) => Promise<void>;
  /** Pass over what was answered, and what is still asked. */
  readonly passOver: () => void;
}

export function useTrial(caseId: string, base: Base, viewer: RefObject<Viewer | null>): Trial {
  const tried = useSignal<Tried | null>(null);
  const waits = useSignal(false);
  const refused = useSignal<Refused | null>(null);
  const turn = useRef(0);
  /** The base as it was drawn last: while an answer is shown, distances are measured to it. */
  const drawn = useRef<Surface | null>(null);
  /** The base as it is when an answer comes, not as it was when that was asked for. */
  const now = useRef(base);
  now.current = base;
  /** What was answered before the limb was here. */
  const early = useRef<{ readonly bytes: ArrayBuffer; readonly body: EditBody; readonly turn: number } | null>(null);

  const take = (bytes: ArrayBuffer, body: EditBody, data: SurfaceData) => {
    const shown = viewer.current?.surface;
    if (shown?.data === data) drawn.current = shown;
    const blocks = decodeBlocks(bytes);
    const surface = changedBy(data, blocks);
    const measured = drawn.current?.data === data ? drawn.current : null;
    // What this page moved for its own preview goes back: distances count from the shape as it is.
    measured?.restore();
    const values = changedDifferences(surface.positions, { positions: data.positions, differences_mm: now.current.differences_mm, surface: measured });
    tried.value = { surface, values, line: (blocks.header.line as Schemas["LineReply"] | null) ?? null, body };
  };

  const ask = async (body: EditBody) => {
    const mine = ++turn.current;
    waits.value = true;
    refused.value = null;
    try {
      const { bytes } = await bytesOf(`/cases/${caseId}/recipe/preview`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify(body),
      });
      if (mine !== turn.current) return;
      if (now.current.data) take(bytes, body, now.current.data);
      else early.current = { bytes, body, turn: mine };
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      if (mine !== turn.current) return;
      refused.value = error;
      tried.value = null;
    } finally {
      if (mine === turn.current && early.current?.turn !== mine) waits.value = false;
    }
  };

  useEffect(() => {
    const answer = early.current;
    if (!base.data || !answer) return;
    early.current = null;
    if (answer.turn !== turn.current) return;
    take(answer.bytes, answer.body, base.data);
    waits.value = false;
  }, [base.data]);

  const passOver = () => {
    turn.current++;
    tried.value = null;
  };

  return { tried, waits, refused, ask, passOver };
}
