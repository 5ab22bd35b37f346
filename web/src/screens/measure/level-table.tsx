/** Girths by level, with a column for the tape; readings between the levels stand below. */
import { Fragment } from "preact";

import type { Schemas } from "../../api/client";
import { fixed, signed, typedAs, within } from "../../numbers";
import { t } from "../../texts";
import { told } from "../../words";
import { type Reading, heightIs } from "../readings";
import type { Measured } from "./measured";
import type { Tape } from "./tape";
import { TapeInput } from "./tape-input";

/** A level this near to a row needs no field of its own. */
const NEAR_ROW_MM = 0.5;

export function LevelTable({ measured, tape }: { measured: Measured; tape: Tape }) {
  const { rows, level, spacing, from } = measured;
  const isRow = (from_reference_mm: number) => rows.some((one) => heightIs(from_reference_mm, one.from_reference_mm));
  const here = level.value;
  const at = here === null ? null : Math.round(here - from);
  return (
    <section class="tab">
      <table>
        <thead>
          <tr>
            <th class="num">{t("th.height")}</th>
            <th class="num">{t("th.girth")}</th>
            <th class="num">±</th>
            <th class="num">{t("th.tape")}</th>
            <th class="num">{t("th.difference")}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((one) => (
            <Fragment key={one.height_mm}>
              <LevelRow
                one={one}
                on={here !== null && Math.abs(here - one.height_mm) < spacing.value / 2}
                tape={tape.readings.find((r) => heightIs(r.height_mm, one.from_reference_mm))}
                onLevel={() => (level.value = one.height_mm)}
                onTape={(girth) => tape.keep(one.from_reference_mm, girth)}
              />
              <NotKept tape={tape} height_mm={one.from_reference_mm} />
            </Fragment>
          ))}
          {tape.readings
            .filter((one) => !isRow(one.height_mm))
            .map((one) => (
              <ReadingRow
                key={one.height_mm}
                one={one}
                onLevel={() => (level.value = one.height_mm + from)}
                onTape={(girth) => tape.keep(one.height_mm, girth)}
              />
            ))}
          {[...tape.wrong.keys()]
            .filter((height) => !isRow(height))
            .map((height) => (
              <NotKept key={`not kept ${height}`} tape={tape} height_mm={height} />
            ))}
        </tbody>
      </table>
      {here !== null && at !== null && !rows.some((one) => Math.abs(one.height_mm - here) < NEAR_ROW_MM) && (
        <div class="row-head at-level">
          <span class="small-note">{t("measure.tape.here", fixed(here - from, 0))}</span>
          <TapeInput key={at} height_mm={at} value={null} onKeep={(girth) => tape.keep(at, girth)} />
        </div>
      )}
    </section>
  );
}

interface RowProps<T> {
  readonly one: T;
  readonly onLevel: () => void;
  readonly onTape: (girth_mm: number | null) => void;
}

function LevelRow({ one, on, tape, onLevel, onTape }: RowProps<Schemas["Level"]> & { on: boolean; tape?: Reading }) {
  return (
    <tr
      class={`pick ${on ? "on" : ""} ${tape?.verdict?.conflict ? "conflict" : ""}`}
      tabIndex={0}
      aria-current={on || undefined}
      onClick={onLevel}
      onFocus={onLevel}
      title={one.reasons?.map(told).join(" ")}
    >
      <td class="num">{fixed(one.from_reference_mm, 0)}</td>
      <td class="num">{fixed(one.tape_mm?.value, 1)}</td>
      <td class="num soft">{within(one.tape_mm?.within, 1)}</td>
      <td class="num">
        <TapeInput height_mm={one.from_reference_mm} value={tape?.girth_mm ?? null} onKeep={onTape} />
      </td>
      <Difference of={tape} />
    </tr>
  );
}

/** A reading at a height at which there is no level. */
function ReadingRow({ one, onLevel, onTape }: RowProps<Reading>) {
  const measured = one.verdict?.measured_mm;
  return (
    <tr class={`pick ${one.verdict?.conflict ? "conflict" : ""}`} tabIndex={0} onClick={onLevel} onFocus={onLevel}>
      <td class="num">{fixed(one.height_mm, 0)}</td>
      <td class="num">{fixed(measured?.value, 1)}</td>
      <td class="num soft">{within(measured?.within, 1)}</td>
      <td class="num">
        <TapeInput height_mm={one.height_mm} value={one.girth_mm} onKeep={onTape} />
      </td>
      <Difference of={one} />
    </tr>
  );
}

/** Beside the reading that was refused: it is not in the field any more. */
function NotKept({ tape, height_mm }: { tape: Tape; height_mm: number }) {
  const found = [...tape.wrong].find(([height]) => heightIs(height, height_mm))?.[1];
  return (
    found && (
      <tr>
        <td colSpan={5}>
          <p class="wrong" role="alert">
            {t("measure.not.kept", fixed(height_mm, 0), found.girth_mm === null ? "–" : typedAs(found.girth_mm))} {found.refused.message}
          </p>
        </td>
      </tr>
    )
  );
}

/** What the server says of a reading; nothing where it has not compared it yet. */
function Difference({ of }: { of?: Reading }) {
  const verdict = of?.verdict;
  const off = verdict?.difference_mm;
  return (
    <td class={`num ${verdict?.conflict ? "a" : "soft"}`}>
      {of && !verdict ? "…" : off === null || off === undefined ? (verdict?.reason ? told(verdict.reason) : "") : signed(off)}
    </td>
  );
}
