/** The upload page of a phone. */
import { Empty } from "../design/parts";
import { t } from "../texts";

export function PhoneScreen({ token: _token }: { token: string }) {
  return (
    <main class="cases" id="content">
      <Empty icon="phone" title={t("phone.not.on")}>
        <p>{t("phone.not.on.how")}</p>
      </Empty>
    </main>
  );
}
