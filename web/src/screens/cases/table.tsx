/** The list of cases. */
import type { Schemas } from "../../api/client";
import { t } from "../../texts";
import { Row } from "./row";

export function CasesTable({ shown, onChange }: { shown: readonly Schemas["Case"][]; onChange: () => void }) {
  return (
    <div class="list">
      <table>
        <thead>
          <tr>
            <th>
              <span class="unseen">{t("cases.th.picture")}</span>
            </th>
            <th>{t("cases.th.case")}</th>
            <th>{t("cases.th.side")}</th>
            <th class="wide-only">{t("cases.th.change")}</th>
            <th>{t("cases.th.state")}</th>
            <th class="step-h wide-only">{t("cases.th.steps")}</th>
            <th>{t("cases.th.next")}</th>
            <th class="num wide-only">{t("cases.th.disk")}</th>
            <th>
              <span class="unseen">{t("cases.th.more")}</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {shown.map((one) => (
            <Row key={one.id} one={one} onChange={onChange} />
          ))}
        </tbody>
      </table>
    </div>
  );
}
