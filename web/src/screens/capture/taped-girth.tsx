/** A girth taped on the limb, which checks the size. */
import { NumberField } from "../../design/parts";
import type { Choices } from "../../state/choices";
import { t } from "../../texts";

interface Props {
  readonly choices: Choices;
  readonly onChange: (part: Partial<Choices>) => void;
}

export function TapedGirth({ choices, onChange: set }: Props) {
  return (
    <>
      <label class="check-line">
        <input
          type="checkbox"
          checked={choices.tape !== null}
          onChange={(event) => set({ tape: event.currentTarget.checked ? { height_mm: null, girth_mm: null } : null })}
        />
        {t("options.tape")}
      </label>
      {choices.tape && (
        <div class="own-board asked">
          <NumberField
            label={t("options.tape.height")}
            unit="mm"
            step={5}
            decimals={1}
            min={0}
            max={2000}
            value={choices.tape.height_mm}
            onChange={(value) => choices.tape && set({ tape: { ...choices.tape, height_mm: value } })}
          />
          <NumberField
            label={t("options.tape.girth")}
            unit="mm"
            step={1}
            decimals={1}
            min={1}
            max={3000}
            value={choices.tape.girth_mm}
            onChange={(value) => choices.tape && set({ tape: { ...choices.tape, girth_mm: value } })}
          />
          <p class="soft">{t("options.tape.how")}</p>
        </div>
      )}
    </>
  );
}
