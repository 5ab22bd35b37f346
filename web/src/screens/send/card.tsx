/** A numbered step of the screen, ticked once it is done. */
import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";

import { Icon } from "../../design/icons";

export function Card({ step, done, title, aside, children }: { step: number; done: boolean; title: string; aside?: string; children: ComponentChildren }) {
  const id = useId();
  return (
    <section class="card gate-card" aria-labelledby={id}>
      <header>
        <span class={`n ${done ? "ok" : "on"}`}>{done ? <Icon name="tick" small /> : step}</span>
        <h2 id={id}>{title}</h2>
        {aside && <span class="soft">{aside}</span>}
      </header>
      {children}
    </section>
  );
}
