/** The camera that took the photos, and the certificate of the kit with its age. */
import type { Schemas } from "../../api/client";
import { Notice } from "../../design/parts";
import { t } from "../../texts";
import { advice, sentence, told } from "../../words";

export function KitLines({ kit }: { kit: Schemas["Kit"] }) {
  return (
    <section class="small-note">
      <p class="soft">{kit.cameras.length ? t("kit.camera", kit.cameras.filter(Boolean).join(", ") || t("kit.camera.unnamed")) : t("kit.none")}</p>
      {kit.setups.map((one) =>
        one.due ? (
          <Notice key={one.camera + one.made} tone="amber" title={sentence(one.finding)}>
            {advice(one.finding)}
          </Notice>
        ) : (
          <p key={one.camera + one.made} class="soft">
            {told(one.finding)}
          </p>
        ),
      )}
    </section>
  );
}
