/** Whether the tape agrees: a conflict comes first; then the girth at the level that is shown. */
import { Button, Chip, Notice } from "../../design/parts";
import { fixed, signed, within } from "../../numbers";
import { t } from "../../texts";
import type { Measured } from "./measured";
import type { Tape } from "./tape";

export function Agreement({ measured, tape }: { measured: Measured; tape: Tape }) {
  const { level, here, row, from } = measured;
  const { readings, waits, conflicts } = tape;
  const title =
    readings.length === 0 ? t("measure.title") : waits ? tape.comparing : conflicts.length ? t("measure.conflicts", conflicts.length) : t("measure.agrees");
  return (
    <>
      <div class="row-head">
        <h2 aria-live="polite">{title}</h2>
        <span class="grow" />
        {readings.length > 0 && <Chip tone={waits ? "plain" : conflicts.length ? "amber" : "green"}>{t("state.tapes", readings.length)}</Chip>}
      </div>
      {conflicts.map((one) => (
        <Notice
          key={one.height_mm}
          tone="amber"
          title={t(
            "measure.conflict",
            fixed(one.height_mm, 0),
            fixed(one.girth_mm, 1),
            fixed(one.verdict?.measured_mm?.value, 1),
            signed(one.verdict?.difference_mm ?? 0),
          )}
          action={<Button onClick={() => (level.value = one.height_mm + from)}>{t("result.show")}</Button>}
        >
          {t("measure.conflict.do", within(one.verdict?.within_mm, 1))}
        </Notice>
      ))}
      <p class="here" role="status">
        {level.value !== null &&
          here &&
          Number.isFinite(here.tape_mm) &&
          t("measure.here", fixed(level.value, 0), fixed(row?.tape_mm?.value ?? here.tape_mm, 1), fixed(row?.contour_mm?.value ?? here.contour_mm, 1))}
      </p>
    </>
  );
}
