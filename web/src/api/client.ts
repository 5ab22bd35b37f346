/**
 * The way to the server: calls typed by its own description, refusals as values to show.
 *
 * `web/openapi.json` is written by the server's command; `npm run types` makes schema.ts of it, so a
 * route that changes breaks the type check here before it breaks in a clinic.
 */
import createClient from "openapi-fetch";
import { signal } from "@preact/signals";
import type { Readable } from "openapi-typescript-helpers";

import { t } from "../texts";
import { type Finding, inParts } from "../words";
import type { components, paths } from "./schema";

/** The shapes of what the server answers. */
export type Schemas = Readable<components["schemas"]>;

/** What is wrong between this page and the program: nothing, nobody signed in, or no answer. */
export const link = signal<"open" | "locked" | "lost">("open");

export const api = createClient<paths>({ baseUrl: location.origin, credentials: "same-origin" });
export const ROOT = `${location.origin}/api/v1`;

api.use({
  onResponse({ response }) {
    noteStatus(response.status);
  },
  onError() {
    link.value = "lost";
  },
});

/** What is no answer: the way is lost, nobody is signed in, the page is locked, a server between is busy. */
const NO_ANSWER: readonly number[] = [0, 401, 423, 502, 503, 504];

/** Keep what a status says of the way to the server. */
export function noteStatus(status: number): void {
  if (status === 401 || status === 423) link.value = "locked";
  else if (status > 0) link.value = "open";
}

/** Something was not done: what happened, why, what to do, in the server's words. */
export class Refused extends Error {
  constructor(
    readonly kind: string,
    readonly what: string,
    readonly status: number,
    readonly more = "",
    /** What the library found; none where the page or the way to the server is at fault. */
    readonly finding: Finding | null = null,
  ) {
    super(more ? `${what} ${more}` : what);
  }

  /** Whether the server has not answered: the same may be asked for again. */
  get unanswered(): boolean {
    return NO_ANSWER.includes(this.status);
  }

  /** The program on this machine does not answer. */
  static lost(): Refused {
    return new Refused("Lost", t("lost"), 0, t("lost.why"));
  }

  static by(kind: string, finding: Finding, status: number): Refused {
    const { what, more } = inParts(finding);
    return new Refused(kind, what, status, more, finding);
  }
}

interface Answer<T> {
  readonly data?: T;
  readonly error?: unknown;
  readonly response: Response;
}

/** The answer of a call, or a `Refused` thrown with the server's sentences. */
export async function answerOf<T>(call: Promise<Answer<T>>): Promise<T> {
  let answer: Answer<T>;
  try {
    answer = await call;
  } catch (error) {
    if (error instanceof TypeError || (error instanceof DOMException && error.name === "TimeoutError")) throw Refused.lost();
    throw error;
  }
  if (answer.error !== undefined || !answer.response.ok) throw refusedBy(answer.response.status, answer.error);
  return answer.data as T;
}

export function refusedBy(status: number, body: unknown): Refused {
  if (typeof body === "object" && body !== null && "message" in body) {
    const kind = "kind" in body ? String(body.kind) : "";
    const finding = "finding" in body ? (body.finding as Finding | null) : null;
    return finding ? Refused.by(kind, finding, status) : new Refused(kind, String(body.message), status);
  }
  return new Refused(`HTTP ${status}`, t("cannot"), status);
}

/** What a route answers in bytes. */
export interface Bytes {
  readonly bytes: ArrayBuffer;
  readonly tag: string;
  /** Whether they are those of the tag that was asked with; then none are sent. */
  readonly unchanged: boolean;
}

/** Bytes of a route, such as a shape, with their tag. */
export async function bytesOf(path: string, init: RequestInit = {}): Promise<Bytes> {
  let response: Response;
  try {
    response = await fetch(`${ROOT}${path}`, { credentials: "same-origin", ...init });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    link.value = "lost";
    throw Refused.lost();
  }
  noteStatus(response.status);
  const unchanged = response.status === 304;
  if (!response.ok && !unchanged) throw refusedBy(response.status, await response.json().catch(() => null));
  return { bytes: await response.arrayBuffer(), tag: response.headers.get("etag") ?? "", unchanged };
}

/** Send a file to a route. */
export async function putFile(path: string, file: File): Promise<void> {
  await bytesOf(path, { method: "PUT", body: file, headers: { "Content-Type": "application/octet-stream" } });
}
