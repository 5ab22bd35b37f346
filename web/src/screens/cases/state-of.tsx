/** What a case says of itself in the list: a chip and one line. */
import type { Schemas } from "../../api/client";
import { Chip } from "../../design/parts";
import { parted } from "../../design/refusal";
import { t, tOr } from "../../texts";
import { told } from "../../words";
import { inShort } from "./in-short";

export function StateOf({ one }: { one: Schemas["Case"] }) {
  if (one.state === "finished" && one.verdict)
    return (
      <>
        <Chip tone={one.verdict.light}>{t(`verdict.${one.verdict.light}`)}</Chip>
        <div class="small soft nt" title={told(one.verdict.headline)}>
          {inShort(one.verdict)}
        </div>
      </>
    );
  if (one.state === "refused" || one.state === "failed")
    return (
      <>
        <Chip tone="red">{t("case.state.refused")}</Chip>
        <div class="small soft nt">{one.finding && parted(told(one.finding))[0]}</div>
      </>
    );
  return (
    <>
      <Chip tone="plain">{tOr(`case.state.${one.state}`, one.state)}</Chip>
      <div class="small soft nt">{one.finding ? told(one.finding) : one.photos ? t("state.photos", one.photos) : ""}</div>
    </>
  );
}
