/** How far apart the levels of a table lie. */
import type { Signal } from "@preact/signals";
import { NumberField } from "../design/parts";
import { t } from "../texts";

export function SpacingField({ spacing }: { readonly spacing: Signal<number> }) {
  return (
    <NumberField
      label={t("measure.spacing")}
      unit="mm"
      step={5}
      decimals={1}
      min={1}
      max={200}
      value={spacing.value}
      onChange={(value) => (spacing.value = value)}
    />
  );
}
