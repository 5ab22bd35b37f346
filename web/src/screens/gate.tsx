/**
 * The gate, on a network: nothing is shown until somebody signed in, and nothing while it is locked.
 *
 * A locked page stays as it is beneath, hidden and out of reach: what was begun in it goes on after
 * the password. On the machine itself there is no gate.
 */
import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";

import "../design/gate.css";
import { Icon } from "../design/icons";
import { Button, Notice } from "../design/parts";
import { askPerson, enter, lockNow, person, signOut } from "../state/person";
import { t } from "../texts";
import type { Parts } from "../words";

export function Gate({ children }: { children: ComponentChildren }) {
  const asked = useSignal(false);
  useEffect(() => {
    void askPerson().then(() => (asked.value = true));
  }, []);
  const one = person.value;
  if (!asked.value) return null;
  const shut = one?.network && (one.locked || !one.open);
  if (shut && !one.locked) return <Entry />;
  return (
    <>
      <div class={shut ? "behind" : "through"} inert={Boolean(shut)} aria-hidden={shut ? true : undefined}>
        {children}
      </div>
      {shut && <Entry user={one.user} />}
    </>
  );
}

/** Who is signed in, with the way out; in the top bar. */
export function WhoIsHere() {
  const one = person.value;
  if (!one?.network || !one.open) return null;
  return (
    <span class="who-is-here">
      <span class="quiet who-name">{one.user}</span>
      <Button bare onClick={() => void lockNow()}>
        {t("gate.lock")}
      </Button>
      <Button bare onClick={() => void signOut()}>
        {t("gate.out")}
      </Button>
    </span>
  );
}

function Entry({ user }: { user?: string }) {
  const why = useSignal<Parts | null>(null);
  const busy = useSignal(false);
  const first = useRef<HTMLInputElement>(null);
  const secret = useRef<HTMLInputElement>(null);
  useEffect(() => first.current?.focus(), []);
  const submit = async (event: Event) => {
    event.preventDefault();
    if (busy.value) return;
    busy.value = true;
    try {
      why.value = await enter(user ?? first.current?.value ?? "", secret.current?.value ?? "");
    } catch {
      why.value = { what: t("lost"), more: t("lost.why") };
    } finally {
      busy.value = false;
      if (why.value) secret.current?.select();
    }
  };
  return (
    <main class="entry" id="content">
      <form class="card" onSubmit={(event) => void submit(event)}>
        <p class="entry-brand">
          <Icon name="limb" />
          limbgram
        </p>
        <h1>{t(user ? "locked" : "gate.sign.in")}</h1>
        <p class="soft">{user ? t("gate.locked.why", user) : t("gate.sign.in.why")}</p>
        {user ? (
          <input class="unseen" name="name" autocomplete="username" value={user} readOnly tabIndex={-1} aria-hidden="true" />
        ) : (
          <label>
            <span>{t("gate.name")}</span>
            <span class="field">
              <input ref={first} name="name" autocomplete="username" autocapitalize="none" spellcheck={false} required maxLength={80} />
            </span>
          </label>
        )}
        <label>
          <span>{t("gate.password")}</span>
          <span class="field">
            <input
              ref={(input) => {
                secret.current = input;
                if (user) first.current = input;
              }}
              type="password"
              name="password"
              autocomplete="current-password"
              required
              maxLength={400}
            />
          </span>
        </label>
        {why.value?.what && (
          <Notice tone="red" title={why.value.what}>
            {why.value.more}
          </Notice>
        )}
        <div class="acts">
          <button type="submit" class="btn go big" aria-busy={busy.value}>
            {t(user ? "gate.unlock" : "gate.sign.in")}
          </button>
          {user && <Button onClick={() => void signOut()}>{t("gate.other")}</Button>}
        </div>
        <p class="small faint">{t("disclaimer")}</p>
      </form>
    </main>
  );
}
