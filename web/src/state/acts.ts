/**
 * Acts: what people change, each with an id of its own, sent in order and again until it is answered.
 *
 * The server does an act once, however often it comes (`limbgram.app.idempotency`), so an answer that is lost
 * on the way costs nothing. Acts of one lane (a case) go one after the other, which keeps the order in
 * which a hand made them; what was not answered yet is kept by this tab and goes on after a reload, or
 * while another screen is looked at. It goes on under the name that made it alone. Until its answer is
 * here an act is `pending`: screens show it over what the server said last, and the answer takes its
 * place in the same moment.
 */
import { batch, signal } from "@preact/signals";
import type { FetchResponse, MaybeOptionalInit } from "openapi-fetch";
import type { HttpMethod, MediaType, PathsWithMethod } from "openapi-typescript-helpers";

import { Refused, answerOf, api } from "../api/client";
import type { paths } from "../api/schema";

export interface Act {
  readonly id: string;
  /** Who made it; empty on the machine itself. */
  readonly by: string;
  /** Acts of one lane are sent one after the other; a case's have its id. */
  readonly lane: string;
  readonly method: string;
  readonly path: string;
  readonly init: { readonly params?: { readonly path?: Readonly<Record<string, unknown>> }; readonly body?: unknown };
}

type Answer<M extends HttpMethod, P extends PathsWithMethod<paths, M>, I> = paths[P][M] extends infer Route extends Record<string | number, unknown>
  ? NonNullable<FetchResponse<Route, I, MediaType>["data"]>
  : never;

interface Options<T> {
  /** Called with the answer in the moment in which the act is no more pending. */
  readonly done?: (answer: T, sent_ms: number) => void;
  /** Asks the server anew; called instead of `done` where the answer is one of before, given again: more may have changed since. */
  readonly again?: () => Promise<unknown>;
  /** Whether the server was asked after that moment; `again` is called then too: another window may have changed since what the answer holds. */
  readonly askedSince?: (moment_ms: number) => boolean;
  /** The act's id, where what is asked for may be asked for twice by one hand: a double Enter. */
  readonly id?: string;
  readonly lane?: string;
}

const KEPT = "limbgram.acts";
const FIRST_WAIT_MS = 400;
const LONGEST_WAIT_MS = 5000;
/** After so long the act is sent again: the server answers it once it is done. */
const SILENCE_MS = 30_000;

/** Acts that are not answered yet, in order. */
export const pending = signal<readonly Act[]>([]);
/** Acts of others that were not answered when they left, and were forgotten when the one who is here came. */
export const forgotten = signal<readonly Act[]>([]);
/** Why an act was refused that no screen waits for any more. */
export const missed = signal<Refused | null>(null);

/** What the page had not finished when it was left; it waits for the one who made it. */
let left: readonly Act[] | null = null;
const unfinished = (): readonly Act[] => (left ??= JSON.parse(sessionStorage.getItem(KEPT) ?? "[]") as Act[]);
/** Who works in this page; null: nobody, and nothing is sent any more. */
let user: string | null = "";

const answers = new Map<string, Promise<unknown>>();
const lanes = new Map<string, Promise<unknown>>();

export const newActId = (): string => [...crypto.getRandomValues(new Uint8Array(12))].map((one) => one.toString(16).padStart(2, "0")).join("");

/** The id of what a form offers: the same however often it is asked for, another once the form says something else. */
export interface Offer {
  readonly idOf: (body: unknown) => string;
  /** It was done: the same once more is another act. */
  readonly over: () => void;
}

export function newOffer(): Offer {
  let [of, id] = ["", ""];
  return {
    idOf(body) {
      const now = JSON.stringify(body);
      if (now !== of) [of, id] = [now, newActId()];
      return id;
    },
    over() {
      of = "";
    },
  };
}

/** Do something of a case, or of all of them (`of` is empty); refused as `answerOf` refuses. */
export function perform<M extends HttpMethod, P extends PathsWithMethod<paths, M>, I extends MaybeOptionalInit<paths[P], M>>(
  of: string,
  method: M,
  path: P,
  init: I,
  { id = newActId(), lane = of, ...options }: Options<Answer<M, P, I>> = {},
): Promise<Answer<M, P, I>> {
  return begin({ id, by: user ?? "", lane, method, path, init: init as Act["init"] }, options as Options<unknown>) as Promise<Answer<M, P, I>>;
}

/** The acts of a case that are pending at a route. */
export const pendingAt = (of: string, path: keyof paths): readonly Act[] =>
  pending.value.filter((one) => one.path === path && one.init.params?.path?.["case_id"] === of);

/** A lane of its own is for what takes long and keeps nothing of its own: files, checks. */
export const isOfFiles = (act: Act): boolean => act.lane.includes(" ");

/** Take up what this user had not finished when the page was left, and forget what others had not; once, when it is known who it is. */
export function resumeActs(name: string): void {
  user = name;
  const before = unfinished();
  left = [];
  keep(pending.value.map((one) => ({ ...one, by: name })));
  forgotten.value = before.filter((one) => one.by !== name);
  for (const act of before.filter((one) => one.by === name)) begin(act, {}).catch(miss);
}

/** Send nothing more: somebody else may be signed in from now on. What is pending waits for its user. */
export function stopActs(): void {
  user = null;
}

/** A refusal that its screen cannot show any more. */
export function miss(error: unknown): void {
  if (!(error instanceof Refused)) throw error;
  missed.value = error;
}

function begin(act: Act, { done, again, askedSince }: Options<unknown>): Promise<unknown> {
  const known = answers.get(act.id);
  if (known) return known;
  keep([...pending.value, act]);
  const before = lanes.get(act.lane) ?? Promise.resolve();
  const answer = before
    .then(() => answered(act))
    .then(
      async ({ found, replayed, sent_ms }) => {
        const asks = (replayed || askedSince?.(sent_ms)) && again;
        if (asks) await asks();
        batch(() => {
          if (!asks) done?.(found, sent_ms);
          end(act);
        });
        return found;
      },
      (error: unknown) => {
        end(act);
        throw error;
      },
    );
  answers.set(act.id, answer);
  lanes.set(
    act.lane,
    answer.catch(() => {}),
  );
  return answer;
}

function end(act: Act): void {
  answers.delete(act.id);
  keep(pending.value.filter((one) => one.id !== act.id));
}

function keep(acts: readonly Act[]): void {
  pending.value = acts;
  const all = [...unfinished(), ...acts];
  if (all.length) sessionStorage.setItem(KEPT, JSON.stringify(all));
  else sessionStorage.removeItem(KEPT);
}

/** The server's answer to an act, however often it has to be asked for. */
async function answered(act: Act): Promise<{ readonly found: unknown; readonly replayed: boolean; readonly sent_ms: number }> {
  const call = api.request as unknown as (method: string, path: string, init: object) => ReturnType<typeof api.GET>;
  for (let wait = FIRST_WAIT_MS; ; wait = Math.min(2 * wait, LONGEST_WAIT_MS)) {
    if (user === null) return new Promise(() => {}); // this page is left
    const sent_ms = performance.now();
    try {
      const sent = call(act.method, act.path, { ...act.init, headers: { "Act-Id": act.id }, signal: AbortSignal.timeout(SILENCE_MS) });
      const found: unknown = await answerOf(sent);
      return { found, replayed: (await sent).response.headers.get("Act-Replayed") === "1", sent_ms };
    } catch (error) {
      if (!(error instanceof Refused) || !error.unanswered) throw error;
      await new Promise((go) => setTimeout(go, wait));
    }
  }
}
