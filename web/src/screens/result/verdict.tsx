/** What is said of the result: the verdict, its size, and what else was found; each finding once. */
import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Chip, Notice } from "../../design/parts";
import { expert } from "../../state/settings";
import { t } from "../../texts";
import { type Finding, inParts, isFinding, same, told } from "../../words";
import { withoutColour } from "../cases";

export function VerdictLines({ info }: { info: Schemas["Case"] }) {
  const verdict = info.verdict;
  if (!verdict) return <p class="lead-line">{info.finding ? told(info.finding) : t("result.none")}</p>;
  const { what: lead, more } = inParts(withoutColour(verdict.headline));
  const said = toldIn(verdict.headline);
  const reasons = said.length ? unsaid(verdict.reasons.slice(0, expert.value ? 20 : 2), said) : [];
  return (
    <>
      <div class="verdict">
        <Chip tone={verdict.light}>{t(`verdict.${verdict.light}`)}</Chip>
        <p class="lead-line">{lead}</p>
      </div>
      {more && <p class="small-note soft">{more}</p>}
      {verdict.light !== "green" && reasons.length > 0 && (
        <ul class="findings small-note soft">
          {reasons.map((one) => (
            <li key={told(one)}>{told(one)}</li>
          ))}
        </ul>
      )}
    </>
  );
}

/** What a tape said of the size, where the verdict above does not say it; or how to have it checked where nothing did. */
export function SizeLines({ tapes, verdict }: { tapes: Schemas["Kit"]["tapes"]; verdict: Schemas["Case"]["verdict"] }) {
  const said = saidOf(verdict);
  if (!tapes.length)
    return verdict && !verdict.size_checked && verdict.light !== "red" ? (
      <Notice tone="amber" title={t("size.unchecked")}>
        {t("size.unchecked.do")}
      </Notice>
    ) : null;
  return (
    <div class="chk said" role="group" aria-label={t("size.tape")}>
      {tapes
        .filter((one) => unsaid([one.finding], said).length)
        .map((one) => (
          <div key={told(one.finding)}>
            <Icon name={one.light === "green" ? "ok" : "warn"} tone={one.light === "green" ? "g" : "a"} />
            {told(one.finding)}
          </div>
        ))}
    </div>
  );
}

/** Whether the limb kept still and what was done with the photos, where the verdict above does not say it. */
export function NoteLines({ notes, verdict }: { notes: Schemas["Kit"]["notes"]; verdict: Schemas["Case"]["verdict"] }) {
  const said = saidOf(verdict);
  const more = unsaid(notes, said);
  if (!more.length) return null;
  return (
    <section class="small-note" role="group" aria-label={t("result.notes")}>
      <h3>{t("result.notes")}</h3>
      {more.map((one) => (
        <p key={told(one)} class="soft">
          {told(one)}
        </p>
      ))}
    </section>
  );
}

/** What the lines of the verdict say to everybody. */
function saidOf(verdict: Schemas["Case"]["verdict"]): Finding[] {
  return verdict ? [...toldIn(verdict.headline), ...verdict.reasons.slice(0, 2)] : [];
}

/** What a headline tells, finding by finding; nothing of a file of an earlier version, which has it in one sentence. */
const toldIn = (headline: Finding): Finding[] => Object.values(withoutColour(headline).values).filter(isFinding);

const unsaid = (found: readonly Finding[], said: readonly Finding[]): Finding[] => found.filter((one) => !said.some((other) => same(one, other)));
