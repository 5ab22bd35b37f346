/** Whether the tape agrees: a conflict comes first; then the girth at the level that is shown. */
import { Button, Chip, Notice } from "../../design/parts";
import { signed } from "../../geometry/scales";
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
        {readings.length > 0 && <Chip tone={waits ? "plain" : conflicts.length ? "amber" : "green"}>{t("measure.tapes", readings.length)}</Chip>}
      </div>
      {conflicts.map((one) => (
        <Notice
          key={one.height_mm}
          tone="amber"
          title={t(
            "measure.conflict",
            one.height_mm.toFixed(0),
            one.girth_mm.toFixed(1),
            one.verdict?.measured_mm?.value.toFixed(1) ?? "–",
            signed(one.verdict?.difference_mm ?? 0),
          )}
          action={<Button onClick={() => (level.value = one.height_mm + from)}>{t("result.show")}</Button>}
        >
          {t("measure.conflict.do", (one.verdict?.within_mm ?? 0).toFixed(1))}
        </Notice>
      ))}
      <p class="here" role="status">
        {level.value !== null &&
          here &&
          Number.isFinite(here.tape_mm) &&
          t("measure.here", level.value.toFixed(0), (row?.tape_mm?.value ?? here.tape_mm).toFixed(1), (row?.contour_mm?.value ?? here.contour_mm).toFixed(1))}
      </p>
    </>
  );
}
