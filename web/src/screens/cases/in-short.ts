/** A verdict in one line of the list. */
import { parted } from "../../design/refusal";
import { t } from "../../texts";
import { type Finding, isFinding, sentence } from "../../words";

/** A verdict without its colour, which the chip beside it shows; a file of an earlier version has it in one sentence. */
export function withoutColour(headline: Finding): Finding {
  const said = headline.values.verdict;
  return isFinding(said) ? said : headline;
}

/** The same in one line of the list: what the surface keeps to, or the first doubt; and whether anything checked the size. */
export function inShort({ headline, size_checked }: { headline: Finding; size_checked: boolean }): string {
  const verdict = withoutColour(headline);
  const { p95_mm, first } = verdict.values;
  const said =
    verdict.code === "verdict.green" && typeof p95_mm === "number"
      ? t("case.within", p95_mm.toFixed(2))
      : isFinding(first) && verdict.code === "verdict.doubtful"
        ? sentence(first)
        : sentence(verdict);
  return size_checked || headline.gravity === "fault" ? inBrief(said) : `${inBrief(said)}; ${t("case.size.unchecked")}`;
}

/** A sentence as far as its first stop. */
const inBrief = (said: string) => parted(said)[0].split(/[:;]|\.$/)[0];
