/** How far apart the levels lie, which sock is in the scan, which shape is measured; and the tables as a file. */
import { Button, NumberField, Segments } from "../../design/parts";
import { expert } from "../../state/settings";
import { t } from "../../texts";
import { term, told } from "../../words";
import { SpacingField } from "../spacing-field";
import type { Measured } from "./measured";

export function MeasureSettings({ measured, edited, onSheet }: { measured: Measured; edited: boolean; onSheet: () => void }) {
  const { of, spacing, sock, found } = measured;
  return (
    <section>
      <div class="row2">
        <SpacingField spacing={spacing} />
        <NumberField
          label={t("measure.sock")}
          unit="mm"
          step={0.1}
          decimals={2}
          min={0}
          max={20}
          value={sock.value}
          onChange={(value) => (sock.value = value)}
        />
      </div>
      {edited && (
        <div class="setting">
          <span>{t("measure.of")}</span>
          <Segments
            label={t("measure.of")}
            value={of.value}
            options={[
              { value: "scan", text: t("measure.of.scan") },
              { value: "rectified", text: t("measure.of.rectified") },
            ]}
            onChange={(value) => (of.value = value)}
          />
        </div>
      )}
      {(of.value === "rectified" || sock.value > 0) && <p class="small faint">{t("measure.tape.by")}</p>}
      <div class="acts">
        <Button icon="save" onClick={onSheet}>
          {t("measure.xlsx")}
        </Button>
      </div>
      {found && <p class="small faint">{t("measure.counted", term(found.counted_from))}</p>}
      {expert.value && found?.notes.map((one) => <p class="small faint">{told(one)}</p>)}
    </section>
  );
}
