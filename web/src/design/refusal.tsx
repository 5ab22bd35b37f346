/** A refusal where it happened: the first sentence says what, the others why and what to do. */
import type { ComponentChildren } from "preact";

import type { Refused } from "../api/client";
import { expert } from "../state/settings";
import { type Finding, told } from "../words";
import { Notice } from "./parts";

export function Refusal({ refused, action }: { refused: Refused | null; action?: ComponentChildren }) {
  if (!refused) return null;
  const [what, rest] = parted(plainly(refused));
  return (
    <Notice tone="red" title={what} action={action}>
      {rest && <p>{rest}</p>}
      {expert.value && <p class="mono">{refused.kind}</p>}
    </Notice>
  );
}

/** A refused edit without its list of coordinates, which no one reads. */
function plainly(refused: Refused): string {
  const finding = innermost(refused.finding);
  if (!finding || finding === refused.finding) return refused.message;
  const text = told(finding);
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}`;
}

/** Why an edit was refused, without which one it was. */
export function innermost(finding: Finding | null): Finding | null {
  switch (finding?.code) {
    case "recipe.edit.refused":
    case "recipe.not_added":
      return innermost(finding.values.reason as Finding);
    case "recipe.edit.asks":
      return { ...finding, code: "recipe.asks" };
    default:
      return finding;
  }
}

/** The first sentence, and the others. */
export function parted(message: string): [string, string] {
  const end = message.search(/[.!?](\s|$)/);
  return end < 0 ? [message, ""] : [message.slice(0, end + 1), message.slice(end + 1).trim()];
}
