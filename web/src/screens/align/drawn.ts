/** The places as they are drawn on the limb: set, held, guessed. */
import { Vector3 } from "three";

import { vec3 } from "../../geometry/vectors";
import { t } from "../../texts";
import type { Mark } from "../../viewer/overlay";
import { term } from "../../words";
import type { Placing } from "./placing";

const MOST_MARKS = 12;

export function marksOf({ places, offered, marks, chosen, held }: Placing): Mark[] {
  const now = held.value;
  const drawn: Mark[] = places
    .filter((one) => one.name !== now?.name)
    .map((one) => ({
      name: one.name,
      label: term(one.name),
      point: new Vector3(...vec3(one.position_mm)),
      state: chosen.value === one.name ? "chosen" : "set",
    }));
  if (now) drawn.push({ name: now.name, label: term(now.name), point: now.point, state: "chosen" });
  const guesses = offered.filter((one) => one.name !== now?.name);
  guesses.forEach((one, i) =>
    drawn.push({
      name: `guess ${i}`,
      label: `${one.name ? term(one.name) : t("align.sticker", one.sticker ?? 0)}?`,
      point: new Vector3(...one.at),
      state: "guess",
    }),
  );
  if (places.length === 0 && !now)
    marks.slice(0, MOST_MARKS).forEach((one, i) => drawn.push({ name: `?${i}`, label: "?", point: new Vector3(...vec3(one.position_mm)), state: "guess" }));
  return drawn;
}
