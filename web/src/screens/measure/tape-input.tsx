/** A field for what the tape read at a height. */
import { WrongNumber, useTyped } from "../../design/parts";
import { fixed, typedAs } from "../../numbers";
import { t } from "../../texts";

export function TapeInput({ height_mm, value, onKeep }: { height_mm: number; value: number | null; onKeep: (girth: number | null) => void }) {
  const typed = useTyped(value === null ? "" : typedAs(value), onKeep, { mayBeEmpty: true });
  return (
    <>
      <input
        class="tape-input"
        inputMode="decimal"
        autocomplete="off"
        placeholder="mm"
        aria-label={t("measure.tape.at", fixed(height_mm, 0))}
        {...typed.input}
        onClick={(event) => event.stopPropagation()}
        onKeyDown={(event) => event.key === "Enter" && typed.commit()}
      />
      {typed.wrong && <WrongNumber text={typed.wrong} />}
    </>
  );
}
