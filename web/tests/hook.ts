/** A hook as a page runs it, without a page: rendered into nothing. */
import { h, render } from "preact";

export interface Running<T> {
  /** What the hook gave last. */
  readonly now: T;
  /** Wait until effects ran and what they changed was rendered. */
  readonly rest: () => Promise<void>;
  readonly leave: () => Promise<void>;
}

const REST_MS = 80;
const rest = () => new Promise<void>((go) => setTimeout(go, REST_MS));

export async function running<T>(hook: () => T): Promise<Running<T>> {
  const page = {} as Element;
  let last: T;
  const Probe = () => {
    last = hook();
    return null;
  };
  render(h(Probe, null), page);
  await rest();
  return {
    get now() {
      return last;
    },
    rest,
    leave: async () => {
      render(null, page);
      await rest();
    },
  };
}
