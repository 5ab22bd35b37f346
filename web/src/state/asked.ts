/** Something asked of the server: what came, or why it did not; asked again when told to. */
import { type Signal, signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";

import { Refused } from "../api/client";

export interface Asked<T> {
  readonly value: Signal<T | null>;
  readonly refused: Signal<Refused | null>;
  readonly busy: Signal<boolean>;
  readonly again: () => Promise<void>;
}

/** Ask now and whenever one of `on` changes; an answer that was overtaken is passed over. */
export function useAsked<T>(ask: () => Promise<T>, on: readonly unknown[]): Asked<T> {
  const asked = useMemo(() => {
    const value = signal<T | null>(null);
    const refused = signal<Refused | null>(null);
    const busy = signal(false);
    const latest = { turn: 0, ask };
    const again = async () => {
      const turn = ++latest.turn;
      busy.value = true;
      try {
        const found = await latest.ask();
        if (turn === latest.turn) [value.value, refused.value] = [found, null];
      } catch (error) {
        if (!(error instanceof Refused)) throw error;
        if (turn === latest.turn) refused.value = error;
      } finally {
        if (turn === latest.turn) busy.value = false;
      }
    };
    return { value, refused, busy, again, latest };
  }, []);
  asked.latest.ask = ask;
  useEffect(() => {
    void asked.again();
  }, on);
  return asked;
}

/** An act with its state: busy while it runs, refused with the reason where it was. */
export function useAct() {
  return useMemo(() => {
    const busy = signal(false);
    const refused = signal<Refused | null>(null);
    const run = async <T>(act: () => Promise<T>): Promise<T | null> => {
      busy.value = true;
      refused.value = null;
      try {
        return await act();
      } catch (error) {
        if (!(error instanceof Refused)) throw error;
        refused.value = error;
        return null;
      } finally {
        busy.value = false;
      }
    };
    return { busy, refused, run };
  }, []);
}
