/** What the check found of the photos, or how to have them checked. */
import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Button } from "../../design/parts";
import { t } from "../../texts";
import { told } from "../../words";
import { someBurnt } from "../coach-words";

type Check = Schemas["Check"];

export function Findings({ said, onCheck }: { said: Check | null; onCheck: (() => void) | null }) {
  const answer = said?.answer;
  const running = said?.state === "running";
  const check = onCheck && !running && !(answer && said?.current) && (
    <div class="acts">
      <Button onClick={onCheck}>{t("capture.check.now")}</Button>
    </div>
  );
  if (!answer)
    return (
      <section class="soft small-note">
        <p>{running ? t("capture.checking.why") : t("capture.check.later")}</p>
        {check}
      </section>
    );
  return (
    <section>
      <div class="chk">
        {checksOf(answer).map((one) => (
          <div key={one.text}>
            <Icon name={one.ok ? "ok" : "warn"} tone={one.ok ? "g" : "a"} />
            {one.text}
          </div>
        ))}
      </div>
      {answer.findings.length > 0 && <List found={answer.findings} />}
      {answer.notes.length > 0 && (
        <>
          <h3>{t("notes")}</h3>
          <List found={answer.notes} />
        </>
      )}
      {check}
    </section>
  );
}

interface Checked {
  readonly ok: boolean;
  readonly text: string;
}

/** The ring, sharpness, the board, stillness and light; what was not looked at is left out. */
function checksOf(answer: NonNullable<Check["answer"]>): Checked[] {
  const { photos, missing, board_photos, kept_still } = answer;
  const placed = photos.some((one) => one.placed);
  const sharp = photos.filter((one) => one.counts).length;
  const lit = !someBurnt(photos);
  const checks: Checked[] = [
    {
      ok: placed && missing.length === 0,
      text: !placed
        ? t("find.ring.none")
        : missing.length === 0
          ? t("find.ring")
          : t("find.ring.gap", answer.largest_gap_deg ? Math.round(answer.largest_gap_deg) : "?"),
    },
    { ok: sharp === photos.length, text: t("find.sharp", sharp, photos.length) },
  ];
  if (board_photos !== null && board_photos !== undefined)
    checks.push({ ok: !answer.findings.some((one) => one.code === "coach.board_unseen"), text: t("find.board", board_photos) });
  if (kept_still !== null && kept_still !== undefined) checks.push({ ok: kept_still, text: t(kept_still ? "find.still" : "find.moved") });
  return [...checks, { ok: lit, text: lit ? t("find.light") : t("find.light.bad") }];
}

function List({ found }: { found: NonNullable<Check["answer"]>["findings"] }) {
  return (
    <ul class="findings small-note soft">
      {found.map(told).map((one) => (
        <li key={one}>{one}</li>
      ))}
    </ul>
  );
}
