/**
 * Who is signed in, on a network: asked of the server when the page opens, and again when it refuses.
 *
 * The server locks a session in which nobody did anything for a while. This page tells it, at most once
 * in 45 s, that somebody moves in it; looking on by itself, as pages do, does not count.
 */
import { effect, signal, untracked } from "@preact/signals";

import { ROOT, type Schemas, api, type Refused, link, refusedBy } from "../api/client";
import { stopActs, resumeActs } from "./acts";

const TELL_MS = 45_000;
const MOVES = ["pointerdown", "pointermove", "keydown", "wheel", "touchstart"] as const;

/** What the server says of this browser; null until it answered. */
export const person = signal<Schemas["Session"] | null>(null);

export async function askPerson(): Promise<void> {
  try {
    const answer = await fetch(`${ROOT}/session`, { credentials: "same-origin" });
    if (answer.ok) person.value = (await answer.json()) as Schemas["Session"];
  } catch {
    // the page says by itself that the program does not answer
  }
}

/** Take notice of refusals and of movement; once, when the page opens. */
export function watch(): void {
  effect(() => {
    if (link.value === "locked") void askPerson();
  });
  let here: string | null = null;
  effect(() => {
    const one = person.value;
    if (!one?.open || one.locked || one.user === here) return;
    const name = one.user;
    if (here !== null)
      leave(); // somebody else signed in, in another tab
    else untracked(() => resumeActs((here = name)));
  });
  let told = 0;
  let moved = Date.now();
  const stay = () => {
    moved = Date.now();
    if (!person.value?.network || person.value.locked || !person.value.open || moved - told < TELL_MS) return;
    told = moved;
    void api.POST("/api/v1/session/stay", {});
  };
  for (const move of MOVES) addEventListener(move, stay, { passive: true, capture: true });
  setInterval(() => {
    const after = person.value?.lock_after_s;
    if (after && !person.value?.locked && Date.now() - moved >= 1000 * after) void askPerson();
  }, 5000);
}

/** Sign in, or unlock; why not, or nothing. */
export async function enter(name: string, password: string): Promise<Refused | null> {
  const locked = person.value?.locked;
  const { data, error, response } = locked
    ? await api.POST("/api/v1/session/unlock", { body: { password } })
    : await api.POST("/api/v1/session/sign-in", { body: { name, password } });
  if (!data) return refusedBy(response.status, error);
  if (locked) person.value = data;
  else leave();
  return null;
}

export async function lockNow(): Promise<void> {
  await api.POST("/api/v1/session/lock", {});
  await askPerson();
}

export async function signOut(): Promise<void> {
  await api.DELETE("/api/v1/session", {});
  leave();
}

/** Nothing of the one who was here is left in the page, but what was not answered: it waits for the same name. */
function leave(): void {
  stopActs();
  location.reload();
}
