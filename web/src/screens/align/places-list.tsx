/** The list of places: a row is pressed to set its place or to look at it. */
import { Vector3 } from "three";

import { Icon } from "../../design/icons";
import { Button } from "../../design/parts";
import { nearestVertex } from "../../geometry/nearest";
import { triple, vec3 } from "../../geometry/vectors";
import { within } from "../../numbers";
import { expert } from "../../state/settings";
import { t, tOr } from "../../texts";
import { term } from "../../words";
import { nudge } from "./keys";
import type { Offered, Place } from "./places";
import type { Placing } from "./placing";
import type { Subject } from "./subject";

interface ListProps {
  readonly subject: Subject;
  readonly placing: Placing;
}

interface RowProps extends ListProps {
  readonly name: string;
  /** Where it is set. */
  readonly place: Place | undefined;
  /** Where it is guessed, while it is neither set nor about to be. */
  readonly guess: Offered | null;
}

export function PlacesList({ subject, placing }: ListProps) {
  const { order, places, offered, armed } = placing;
  return (
    <ul class="places-list">
      {order.map((name) => {
        const place = places.find((one) => one.name === name);
        const guess = !place && armed.value !== name ? (offered.find((one) => one.name === name) ?? null) : null;
        return <Row key={name} subject={subject} placing={placing} name={name} place={place} guess={guess} />;
      })}
    </ul>
  );
}

function Row(props: RowProps) {
  const { subject, placing, name, place } = props;
  const { armed, chosen, leftOut } = placing;
  const now = armed.value === name;
  const press = () => {
    if (place) {
      chosen.value = name;
      armed.value = null;
      lookAt(subject, place);
    } else {
      armed.value = now ? null : name;
      leftOut.value = new Set([...leftOut.value].filter((one) => one !== name));
    }
  };
  return (
    <li class={`${now || chosen.value === name ? "on" : ""} ${place ? "placed" : ""} ${leftOut.value.has(name) ? "left-out" : ""}`}>
      <button type="button" class="place-row" aria-pressed={now} onKeyDown={(event) => nudge(subject, placing, name, event)} onClick={press}>
        <span class={`mark ${place ? "set" : now ? "now" : ""}`} aria-hidden="true">
          {place ? <Icon name="tick" small /> : null}
        </span>
        <span class="grow">{term(name)}</span>
        <span class="num faint small">{stateOf(props)}</span>
      </button>
      <RowButton {...props} />
      {expert.value && place?.in_limb_mm && <span class="mono xyz">{place.in_limb_mm.map((v) => v.toFixed(1)).join(" ")}</span>}
    </li>
  );
}

/** How a place stands, in words: guessed, how sure, to be pressed, left out, or where it lies. */
function stateOf({ placing: { armed, leftOut, known }, name, place, guess }: RowProps): string {
  if (guess) return t(`align.guess.${guess.by}`, within(guess.within_mm, 1));
  if (place) return place.within_mm ? `± ${within(place.within_mm, 2)} mm` : "";
  if (armed.value === name) return t("align.press");
  if (leftOut.value.has(name)) return t("align.left");
  const facing = known.find((one) => one.name === name)?.facing;
  return facing && facing !== "none" ? tOr(`facing.${facing}`, facing) : "";
}

/** What else can be done with it: confirm a guess, take it away, leave it out. */
function RowButton({ placing, name, place, guess }: RowProps) {
  const { armed, leftOut, put, remove, after } = placing;
  if (guess) {
    const found = guess.by === "visit" ? ({ placed: "proposed", sigma_mm: guess.sigma_mm } as const) : undefined;
    return (
      <Button bare onClick={() => put(name, new Vector3(...guess.at), found)} label={t("align.guess.confirm.long", term(name))}>
        {t("align.guess.confirm")}
      </Button>
    );
  }
  if (place) return <Button bare icon="close" class="icon-only" label={t("align.remove", term(name))} onClick={() => remove(name)} />;
  if (armed.value !== name) return null;
  const leave = () => {
    leftOut.value = new Set([...leftOut.value, name]);
    armed.value = after(name);
  };
  return (
    <Button bare onClick={leave}>
      {t("align.leave")}
    </Button>
  );
}

/** Straight at a place, along the normal of the surface there. */
function lookAt({ viewer }: Subject, { position_mm }: Place): void {
  const v = viewer.current;
  if (!v?.surface) return;
  const at = vec3(position_mm);
  v.lookAt(new Vector3(...at), new Vector3(...triple(v.surface.normals, nearestVertex(v.surface.positions, at))));
}
