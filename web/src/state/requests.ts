/** Something asked of the server: what came, or why it did not; asked again when told to. */
import { type Signal, signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";

import { Refused } from "../api/client";
import { miss } from "./acts";

const RETRY_MS = 2000;

export interface Query<T> {
  readonly value: Signal<T | null>;
  readonly refused: Signal<Refused | null>;
  readonly busy: Signal<boolean>;
  readonly again: () => Promise<void>;
  /** Take what an act answered: newer than whatever was asked before it. */
  readonly put: (found: T) => void;
  /** Whether it was asked for after that moment. */
  readonly askedSince: (moment_ms: number) => boolean;
}

/** Ask now and whenever one of `on` changes; an answer that was overtaken is passed over, one that was lost asked for again. */
export function useQuery<T>(ask: () => Promise<T>, on: readonly unknown[]): Query<T> {
  const asked = useMemo(() => {
    const value = signal<T | null>(null);
    const refused = signal<Refused | null>(null);
    const busy = signal(false);
    const latest = { turn: 0, ask, asked_ms: -Infinity };
    const put = (found: T) => {
      latest.turn++;
      [value.value, refused.value, busy.value] = [found, null, false];
    };
    const again = async () => {
      const turn = ++latest.turn;
      busy.value = true;
      latest.asked_ms = performance.now();
      try {
        const found = await latest.ask();
        if (turn === latest.turn) [value.value, refused.value] = [found, null];
      } catch (error) {
        if (!(error instanceof Refused)) throw error;
        if (turn !== latest.turn) return;
        refused.value = error;
        if (error.status === 0) setTimeout(() => turn === latest.turn && void again(), RETRY_MS);
      } finally {
        if (turn === latest.turn) busy.value = false;
      }
    };
    const askedSince = (moment_ms: number) => latest.asked_ms > moment_ms;
    return { value, refused, busy, again, put, askedSince, latest };
  }, []);
  asked.latest.ask = ask;
  useEffect(() => {
    void asked.again();
  }, on);
  useEffect(() => () => void asked.latest.turn++, []);
  return asked;
}

/** An act with its state: busy while one runs, refused with the reason where the last one was. */
export function useAct() {
  const made = useMemo(() => {
    const running = signal(0);
    const refused = signal<Refused | null>(null);
    const screen = { open: true };
    const run = async <T>(act: () => Promise<T>): Promise<T | null> => {
      running.value++;
      refused.value = null;
      try {
        return await act();
      } catch (error) {
        if (!(error instanceof Refused)) throw error;
        if (screen.open) refused.value = error;
        else miss(error);
        return null;
      } finally {
        running.value--;
      }
    };
    return {
      busy: {
        get value() {
          return running.value > 0;
        },
      },
      refused,
      run,
      screen,
    };
  }, []);
  useEffect(() => () => void (made.screen.open = false), []);
  return made;
}
