/** Who answers for a file of a red result. */
import { t } from "../../texts";
import { Card } from "./card";
import type { Export } from "./export";

export function SignerCard({ made: { signer, write }, step }: { made: Export; step: number }) {
  return (
    <Card step={step} done={signer.value.trim() !== ""} title={t("send.red")} aside={t("send.red.why")}>
      <span class="field wide">
        <input
          aria-label={t("send.red.who")}
          placeholder={t("send.red.who")}
          maxLength={300}
          value={signer.value}
          onInput={(event) => (signer.value = event.currentTarget.value)}
          onChange={() => write()}
        />
      </span>
    </Card>
  );
}
