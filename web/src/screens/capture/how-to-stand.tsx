/** From where the photos that are asked for are taken. */
import type { Schemas } from "../../api/client";
import { t } from "../../texts";
import { told } from "../../words";
import { standWords } from "../coach-words";
import { additions, placeWords } from "./additions";

export function HowToStand({ answer }: { answer: NonNullable<Schemas["Check"]["answer"]> }) {
  const letters = additions(answer).map((one) => one.letter);
  return (
    <section>
      <div class="two">
        <svg width="150" height="132" viewBox="0 0 150 132" class="stand" aria-hidden="true">
          <path class="limb-shape" d="M96 118h34c-2-14 2-24 0-40-2-14-6-34-17-34s-15 20-17 34c-2 16 2 26 0 40z" />
          <path class="floor" d="M84 122h62" />
          <path class="ray" d="M34 24 104 62M26 80h70" />
          <g transform="translate(26 20) rotate(28)" class="lens">
            <rect x="-12" y="-8" width="20" height="16" rx="2.5" />
            <rect x="8" y="-4" width="6" height="8" />
          </g>
          <g transform="translate(18 80)" class="lens">
            <rect x="-12" y="-8" width="20" height="16" rx="2.5" />
            <rect x="8" y="-4" width="6" height="8" />
          </g>
        </svg>
        <div>
          <h2>
            {letters.length > 1
              ? t("capture.photos.letters", letters.slice(0, -1).join(", "), letters[letters.length - 1])
              : t("photo.number", letters[0] ?? "")}
          </h2>
          {answer.missing.slice(0, 3).map((one) => (
            <p class="soft" key={told(one.asked)}>
              {standWords(
                one,
                one.azimuths_deg.map((azimuth_deg, i) => placeWords(azimuth_deg, one.elevations_deg[i])),
              )}
            </p>
          ))}
          <p class="small faint">{t("coach.same")}</p>
        </div>
      </div>
    </section>
  );
}
