/** Which of the case's shapes is compared, how the two are laid on each other, and how far apart levels lie. */
import type { Signal } from "@preact/signals";

import { Segments } from "../../design/parts";
import { t } from "../../texts";
import { SpacingField } from "../spacing-field";
import { type Way, WAYS, type Which } from "./compared";

interface Props {
  readonly of: Which;
  /** Nothing to choose: the case has its scan alone. */
  readonly onlyScan: boolean;
  readonly onOf: (of: Which) => void;
  readonly way: Signal<Way>;
  readonly spacing_mm: Signal<number>;
}

export function HowLaid({ of, onlyScan, onOf, way, spacing_mm }: Props) {
  return (
    <section>
      {!onlyScan && (
        <div class="setting">
          <span>{t("compare.this")}</span>
          <Segments
            label={t("compare.this")}
            value={of}
            options={[
              { value: "scan", text: t("measure.of.scan") },
              { value: "rectified", text: t("measure.of.rectified") },
            ]}
            onChange={onOf}
          />
        </div>
      )}
      <label class="stacked">
        <span>{t("compare.laid")}</span>
        <span class="field">
          <select value={way.value} onChange={(event) => (way.value = event.currentTarget.value as Way)}>
            {WAYS.map((value) => (
              <option key={value} value={value}>
                {t(`compare.way.${value}`)}
              </option>
            ))}
          </select>
        </span>
        <span class="small faint">{t(`compare.way.how.${way.value}`)}</span>
      </label>
      <SpacingField spacing={spacing_mm} />
    </section>
  );
}
