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
    note(response.status);
  },
  onError() {
    link.value = "lost";
  },
});

/** Keep what a status says of the way to the server. */
export function note(status: number): void {
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
export async function taken<T>(call: Promise<Answer<T>>): Promise<T> {
  let answer: Answer<T>;
  try {
    answer = await call;
  } catch (error) {
    if (error instanceof TypeError || (error instanceof DOMException && error.name === "TimeoutError")) throw new Refused("Lost", t("lost"), 0, t("lost.why"));
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

/** Bytes of a route, with its tag, for shapes. */
export async function bytesOf(path: string, init: RequestInit = {}): Promise<{ bytes: ArrayBuffer; tag: string; response: Response }> {
  let response: Response;
  try {
    response = await fetch(`${ROOT}${path}`, { credentials: "same-origin", ...init });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    link.value = "lost";
    throw new Refused("Lost", t("lost"), 0, t("lost.why"));
  }
  note(response.status);
  if (!response.ok) throw refusedBy(response.status, await response.json().catch(() => null));
  return { bytes: await response.arrayBuffer(), tag: response.headers.get("etag") ?? "", response };
}
