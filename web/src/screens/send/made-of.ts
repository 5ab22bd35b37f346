/** Files of one limb, told apart. */
import type { Schemas } from "../../api/client";
import { t } from "../../texts";

/** What tells a file from another of the same limb: its side, its edits, who signed for it, and which scan and recipe are in it. */
export function madeOf(one: Pick<Schemas["ExportedFile"], "side" | "recipe_edits" | "signed_by" | "scan_sha256" | "recipe_sha256">): string {
  const short = (sha256: string) => sha256.slice(0, 8);
  return [
    one.side === "none" ? "" : t(one.side === "left" ? "side.LEFT" : "side.RIGHT"),
    t("state.edits", one.recipe_edits),
    one.signed_by && t("send.signed", one.signed_by),
    t("send.of.scan", short(one.scan_sha256)),
    one.recipe_sha256 && t("send.of.recipe", short(one.recipe_sha256)),
  ]
    .filter(Boolean)
    .join(" · ");
}
