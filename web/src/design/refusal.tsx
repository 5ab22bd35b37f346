/** A refusal where it happened: the first sentence says what, the others why and what to do. */
import type { ComponentChildren } from "preact";

import type { Refused } from "../api/client";
import { expert } from "../state/settings";
import { Notice } from "./parts";

export function Refusal({ refused, action }: { refused: Refused | null; action?: ComponentChildren }) {
  if (!refused) return null;
  const [what, rest] = parted(withoutNumbers(refused.message));
  return (
    <Notice tone="red" title={what} action={action}>
      {rest && <p>{rest}</p>}
      {expert.value && <p class="mono">{refused.kind}</p>}
    </Notice>
  );
}

/** A refused edit without its list of coordinates, which no one reads: "Edit 3 (load: ...): why" keeps why. */
export function withoutNumbers(message: string): string {
  return message.replace(/^Edit \d+ \([\s\S]*?\): /, "");
}

/** The first sentence, and the others. */
export function parted(message: string): [string, string] {
  const end = message.search(/[.!?](\s|$)/);
  return end < 0 ? [message, ""] : [message.slice(0, end + 1), message.slice(end + 1).trim()];
}
