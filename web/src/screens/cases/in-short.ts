/** A verdict in one line of the list. */
import { type Finding, briefly, isFinding } from "../../words";

/** A verdict without its colour, which the chip beside it shows; a file of an earlier version has it in one sentence. */
export function withoutColour(headline: Finding): Finding {
  const said = headline.values.verdict;
  return isFinding(said) ? said : headline;
}

/** The same in one line of the list: what the surface keeps to, or the first doubt. */
export const inShort = (headline: Finding): string => briefly(withoutColour(headline));

/** Whether a row has to say that nothing checked the size: not of a capture that is refused anyhow. */
export const sizeUnchecked = ({ headline, size_checked }: { headline: Finding; size_checked: boolean }): boolean =>
  !size_checked && headline.gravity !== "fault";
