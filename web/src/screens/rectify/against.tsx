/** What the colours are held against: the scan, or the shape before one of the edits. */
import type { Schemas } from "../../api/client";
import { t } from "../../texts";
import { summaryOf } from "../edit-words";
import type { Workspace } from "./workspace";

export function Against({ workspace: { base, mode }, edits }: { workspace: Workspace; edits: readonly Schemas["EditReply"][] }) {
  if (edits.length < 2) return null;
  const choose = (edit: string) => {
    base.against(edit ? Number(edit) : null);
    mode.value = "difference";
  };
  return (
    <section>
      <label class="stacked">
        <span>{t("against.which")}</span>
        <span class="field">
          <select value={base.before ?? ""} onChange={(event) => choose(event.currentTarget.value)}>
            <option value="">{t("compare.scan")}</option>
            {edits.slice(1).map((one) => (
              <option key={one.number} value={one.number}>
                {t("compare.before.edit", one.number, summaryOf(one).title)}
              </option>
            ))}
          </select>
        </span>
      </label>
    </section>
  );
}
