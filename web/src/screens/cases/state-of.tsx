/** What a case says of itself in the list: a chip and one line. */
import type { Schemas } from "../../api/client";
import { Chip } from "../../design/parts";
import { t } from "../../texts";
import { briefly, told } from "../../words";
import { inShort, sizeUnchecked } from "./in-short";

export function StateOf({ one }: { one: Schemas["Case"] }) {
  if (one.state === "finished" && one.verdict)
    return (
      <>
        <Chip tone={one.verdict.light}>{t(`verdict.${one.verdict.light}`)}</Chip>
        <div class="small soft nt" title={told(one.verdict.headline)}>
          {inShort(one.verdict.headline)}
        </div>
        {sizeUnchecked(one.verdict) && <div class="small soft">{t("case.size.unchecked")}</div>}
      </>
    );
  if (one.state === "refused" || one.state === "failed")
    return (
      <>
        <Chip tone="red">{t(`case.state.${one.state}`)}</Chip>
        <div class="small soft nt">{one.finding && briefly(one.finding)}</div>
      </>
    );
  return (
    <>
      <Chip tone="plain">{t(`case.state.${one.state}`)}</Chip>
      <div class="small soft nt">{one.finding ? told(one.finding) : one.photos ? t("state.photos", one.photos) : ""}</div>
    </>
  );
}
