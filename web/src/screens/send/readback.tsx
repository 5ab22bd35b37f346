/** What the server read back of the file that it wrote. */
import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Chip, Notice } from "../../design/parts";
import { bytes, fixed, signed } from "../../numbers";
import { expert } from "../../state/settings";
import { t } from "../../texts";
import { type Finding, told } from "../../words";

export function Readback({ w }: { w: Schemas["ExportedFile"] | null }) {
  return (
    <>
      <section>
        <h3>{t("send.file")}</h3>
        <p class="file-name">{w?.name ?? "–"}</p>
        <p class="small faint">{w ? `${bytes(w.bytes)}, ${w.unit}. ${t("send.noname")}` : t("send.file.later")}</p>
      </section>
      {w && (
        <section>
          <div class="row-head">
            <h2>{t("send.readback")}</h2>
            <span class="grow" />
            <Chip tone={w.doubt ? "amber" : "green"}>{t("send.agrees.chip")}</Chip>
          </div>
          <table class="kv">
            <tbody>
              <Fact name={t("send.fact.side")} value={w.side === "left" ? t("side.LEFT") : w.side === "right" ? t("side.RIGHT") : "–"} />
              <Fact name={t("send.fact.unit")} value={w.unit} />
              {known_(w.surface_within_mm) && <Fact name={t("mode.surface")} value={t("send.within", fixed(w.surface_within_mm, 2))} />}
              {known_(w.girth_change_mm) && <Fact name={t("send.fact.girths")} value={t("send.most", signed(w.girth_change_mm ?? 0, 2))} />}
              {known_(w.volume_change) && <Fact name={t("volume")} value={`${signed(100 * (w.volume_change ?? 0), 2)} %`} />}
              {known_(w.minutes) && <Fact name={t("send.fact.minutes")} value={`${fixed(w.minutes, 0)} min`} />}
              <Fact name={t("recipe")} value={t("state.edits", w.recipe_edits)} />
            </tbody>
          </table>
          <ul class="findings small-note soft">
            {(w.said ?? []).map((one) => (
              <li key={told(one as Finding)}>{told(one as Finding)}</li>
            ))}
          </ul>
          {expert.value && <p class="mono">sha256 {w.sha256}</p>}
        </section>
      )}
      {(w?.notes ?? []).map((one) => (
        <section key={told(one as Finding)}>
          <Notice tone="amber" title={told(one as Finding)} />
        </section>
      ))}
      {w?.doubt && (
        <section>
          <Notice tone="red" title={told(w.doubt as Finding)} />
        </section>
      )}
    </>
  );
}

const known_ = (value: number | null | undefined): boolean => value !== null && value !== undefined;

function Fact({ name, value }: { name: string; value: string }) {
  return (
    <tr>
      <td>{name}</td>
      <td>
        <span class="g ok-mark">
          <Icon name="ok" small />
        </span>
        {value}
      </td>
    </tr>
  );
}
