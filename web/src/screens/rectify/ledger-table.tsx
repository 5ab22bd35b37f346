/** The ledger: girths by height before, now and by the edit that is open, and where each edit did most. */
import type { Schemas } from "../../api/client";
import { fixed, signed } from "../../numbers";
import { t } from "../../texts";
import { toneOf } from "./effect";
import { type Ledgered, changed } from "./ledger";

/** A row is the level that is looked at, where it is so near to it. */
const NEAR_MM = 8;

interface Props {
  readonly ledger: NonNullable<Ledgered["ledger"]>;
  /** Of the edit that is open: the girths before and after it. */
  readonly line: Schemas["LineReply"] | null;
  readonly level: number | null;
  readonly onLevel: (height_mm: number) => void;
}

export function LedgerTable(props: Props) {
  const { ledger } = props;
  return (
    <section class="ledger">
      <Head volume={ledger.volume} />
      <table class="led">
        <thead>
          <tr>
            <th class="num">{t("th.height")}</th>
            <th class="num">{t("measure.of.scan")}</th>
            <th class="num">{t("th.now")}</th>
            <th class="num">{t("th.change")}</th>
            <th class="num">{t("th.this")}</th>
          </tr>
        </thead>
        <Girths {...props} />
        <Extremes {...props} />
      </table>
      <Span volume={ledger.volume} />
    </section>
  );
}

function Head({ volume }: { volume: Schemas["VolumeChange"] | null | undefined }) {
  const all_ml = changed(volume);
  return (
    <div class="row-head">
      <h2>{t("ledger")}</h2>
      <span class="grow" />
      <span class="small soft">
        {t("ledger.all")} <b>{all_ml === null ? "–" : `${signed(all_ml)} mL`}</b>
        {all_ml !== null && volume && volume.before_ml > 0 && `, ${signed((100 * all_ml) / volume.before_ml)} %`}
      </span>
    </div>
  );
}

/** The girth at each height: of the scan, now, and what all edits and this one made of it. */
function Girths({ ledger, line, level, onLevel }: Props) {
  const scan_mm = ledger.lines[0].before.girths_mm;
  const last = ledger.lines[ledger.lines.length - 1];
  const now_mm = (line?.after ?? last.after).girths_mm;
  const before_mm = (line?.before ?? last.before).girths_mm;
  return (
    <tbody>
      {[...ledger.levels_mm.keys()].reverse().map((i) => {
        const height_mm = ledger.levels_mm[i];
        const all_mm = less(now_mm[i], scan_mm[i]);
        const this_mm = less(now_mm[i], before_mm[i]);
        const on = level !== null && Math.abs(level - height_mm) < NEAR_MM;
        return (
          <tr key={height_mm} class={`pick ${on ? "on" : ""}`} tabIndex={0} onClick={() => onLevel(height_mm)} onFocus={() => onLevel(height_mm)}>
            <td class="num">{fixed(height_mm, 0)}</td>
            <td class="num soft">{fixed(scan_mm[i], 1)}</td>
            <td class="num">{fixed(now_mm[i], 1)}</td>
            <td class={`num ${toneOf(all_mm ?? 0)}`}>{all_mm === null ? "–" : signed(all_mm)}</td>
            <td class="num soft">{this_mm === null ? "–" : signed(this_mm)}</td>
          </tr>
        );
      })}
    </tbody>
  );
}

/** Where each edit changed the girth most. */
function Extremes({ ledger, onLevel }: Props) {
  const most = ledger.lines.flatMap((one) => (one.extreme ? [{ number: one.number, ...one.extreme }] : []));
  if (!most.length) return null;
  return (
    <tbody>
      <tr>
        <th colSpan={5} scope="colgroup">
          {t("ledger.most")}
        </th>
      </tr>
      {most.map(({ number, height_mm, before_mm, after_mm }) => {
        const change_mm = less(after_mm, before_mm);
        return (
          <tr key={number} class="pick" tabIndex={0} onClick={() => onLevel(height_mm)} onFocus={() => onLevel(height_mm)}>
            <td class="num">{fixed(height_mm, 0)}</td>
            <td class="num soft">{fixed(before_mm, 1)}</td>
            <td class="num">{fixed(after_mm, 1)}</td>
            <td class="num soft">{number}.</td>
            <td class="num">{change_mm === null ? "–" : signed(change_mm)}</td>
          </tr>
        );
      })}
    </tbody>
  );
}

/** Between which heights the volume counts. */
function Span({ volume }: { volume: Schemas["VolumeChange"] | null | undefined }) {
  if (!volume || (volume.low_mm === null && volume.high_mm === null)) return null;
  return <p class="small faint">{t("ledger.span", fixed(volume.low_mm ?? 0, 0), fixed(volume.high_mm, 0))}</p>;
}

const less = (one: number | null, other: number | null): number | null => (one === null || other === null ? null : one - other);
