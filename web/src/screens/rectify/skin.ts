/** Which skin of the shape after a recipe touches the limb. */
import type { Schemas } from "../../api/client";
import type { Skin } from "../../geometry/section";

type Edited = Pick<Schemas["EditReply"], "kind" | "parameters"> & { readonly on?: boolean };

/** Of a wall that was made outwards, its inside; of everything else, the outside: as the ledger has it. */
export function touching(edits: readonly Edited[]): Skin {
  const wall = edits.findLast((one) => one.kind === "wall" && one.on !== false);
  return wall && ((wall.parameters as Record<string, unknown>)["side"] ?? "outward") === "outward" ? "hollow" : "outline";
}
