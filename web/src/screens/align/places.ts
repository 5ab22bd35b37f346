/** The places of a limb: those that are set, those that have a name and are not, and those that are guessed. */
import type { Schemas } from "../../api/client";
import { type Vec3, distance, vec3 } from "../../geometry/vectors";
import type { Act } from "../../state/acts";

export type Place = Schemas["Place"];
export type Known = Pick<Schemas["TemplateName"], "name" | "facing">;

/** A place this near to a guess is that one. */
export const SAME_MM = 3;

/** A place that is guessed; a sticker has no name until one was placed on it once. */
export interface Offered {
  readonly name: string;
  readonly sticker: number | null;
  readonly by: Schemas["Guess"]["by"];
  readonly at: Vec3;
  /** How well another scan of the limb tells it: one standard deviation, and ± in 95 of 100. */
  readonly sigma_mm: number | null;
  readonly within_mm: number | null;
}

/** The places once the acts that are pending are done. */
export function withPending(kept: readonly Place[], acts: readonly Pick<Act, "method" | "init">[]): readonly Place[] {
  let places = kept;
  for (const { method, init } of acts) {
    const name = String(init.params?.path?.["name"]);
    const others = places.filter((one) => one.name !== name);
    places = method === "delete" ? others : [...others, { name, ...(init.body as Schemas["PlaceMark"]) }];
  }
  return places;
}

/** All names in the order of the list: those of the kind, then those that somebody set besides. */
export function orderOf(known: readonly Known[], places: readonly Place[]): string[] {
  return [...known.map((one) => one.name), ...places.map((one) => one.name).filter((name) => !known.some((one) => one.name === name))];
}

/** The name to place after one: the next that is neither set nor left out, round to the first. */
export function nextAfter(name: string, order: readonly string[], places: readonly Place[], left: ReadonlySet<string>): string | null {
  const have = new Set([...places.map((one) => one.name), name]);
  const at = order.indexOf(name);
  return [...order.slice(at + 1), ...order.slice(0, at)].find((one) => !have.has(one) && !left.has(one)) ?? null;
}

/** The guesses that are not set yet, each with the name that it would have. */
export function offeredOf(guesses: readonly Schemas["Guess"][], places: readonly Place[], nameOfSticker: (sticker: number) => string): Offered[] {
  return guesses
    .map((one): Offered => ({
      name: one.name || (one.sticker !== null && one.sticker !== undefined ? nameOfSticker(one.sticker) : ""),
      sticker: one.sticker ?? null,
      by: one.by,
      at: vec3(one.position_mm),
      sigma_mm: one.sigma_mm ?? null,
      within_mm: one.within_mm ?? null,
    }))
    .filter((one) => !places.some((p) => p.name === one.name || distance(vec3(p.position_mm), one.at) < SAME_MM));
}
