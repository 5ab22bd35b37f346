/** A refusal where it happened: the title says what, the text why and what to do. */
import type { ComponentChildren } from "preact";

import type { Refused } from "../api/client";
import { expert } from "../state/settings";
import { type Finding, type Parts, inParts } from "../words";
import { Notice } from "./parts";

export function Refusal({ refused, action }: { refused: Refused | null; action?: ComponentChildren }) {
  if (!refused) return null;
  const { what, more } = plainly(refused);
  return (
    <Notice tone="red" title={what} action={action}>
      {more && <p>{more}</p>}
      {expert.value && <p class="mono">{refused.kind}</p>}
    </Notice>
  );
}

/** A refused edit without its list of coordinates, which no one reads. */
function plainly(refused: Refused): Parts {
  const finding = innermost(refused.finding);
  if (!finding || finding === refused.finding) return refused;
  const { what, more } = inParts(finding);
  return { what: `${what.charAt(0).toUpperCase()}${what.slice(1)}`, more };
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
