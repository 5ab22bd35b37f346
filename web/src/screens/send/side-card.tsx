/** Which side it is: asked without a guess, and held against what the case says. */
import { Icon } from "../../design/icons";
import { Notice } from "../../design/parts";
import { t } from "../../texts";
import { Card } from "./card";
import type { Export } from "./export";

export function SideCard({ made: { side, known, other, write }, step }: { made: Export; step: number }) {
  return (
    <Card step={step} done={side.value !== null && !other} title={t("send.side")} aside={t("send.side.look")}>
      <div class="gate" role="radiogroup" aria-label={t("send.side")}>
        {(["right", "left"] as const).map((one) => (
          <button
            key={one}
            type="button"
            role="radio"
            aria-checked={side.value === one}
            class={`lr ${one} ${side.value === one ? "on" : ""}`}
            onClick={() => write({ side: one })}
          >
            <b aria-hidden="true">{t(one === "left" ? "side.L" : "side.R")}</b>
            <span>
              {t(`side.${one}`)}
              {side.value === one && <small>{known === one ? t("send.agrees") : known ? t("send.contradicts") : ""}</small>}
            </span>
            {side.value === one && <Icon name={other ? "warn" : "tick"} />}
          </button>
        ))}
      </div>
      {other && (
        <Notice tone="red" title={t("send.contradiction")}>
          {t("send.contradiction.do")}
        </Notice>
      )}
    </Card>
  );
}
