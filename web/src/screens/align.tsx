/**
 * Align: where are side, front and axis? Places are marked on the limb, then the axes follow them.
 *
 * A place is set on release, so a hand may slide to it; it is glued to the surface and can be dragged.
 * Navigation stays as it is meanwhile: right-drag, two fingers, wheel, and drags beside the limb.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { Vector3 } from "three";

import { type Schemas, api, taken } from "../api/client";
import { Icon } from "../design/icons";
import { Button, Chip, Notice, NumberField, Segments } from "../design/parts";
import { Refusal } from "../design/refusal";
import { type ByHand, STILL, isStill, turned } from "../geometry/byhand";
import { type Vec3, distance, vec3 } from "../geometry/vectors";
import { type Act, perform, pendingAt } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { kindName, limbKinds, sided } from "../limb-kinds";
import { expert } from "../state/settings";
import { nameOfSticker, rememberSticker } from "../state/stickers";
import { t, tOr } from "../texts";
import type { Mark } from "../viewer/overlay";
import { Stage, type Shown } from "../viewer/stage";
import type { Mode } from "../viewer/surface";
import type { Tool, Viewer } from "../viewer/viewer";
import { term } from "../words";
import { said } from "./edit-words";
import { useLimb } from "./limb";
import { Loupe } from "./loupe";
import type { RoomProps } from "./room";

const PLACE = "/api/v1/cases/{case_id}/limb/places/{name}";
const GRAB_PX = 14;
const GRAB_TOUCH_PX = 30;
/** A place this near to a guess is that one. */
const SAME_MM = 3;
/** A hand this near to a guess lands on it. */
const CATCH_MM = 4;

export function AlignScreen({ room }: RoomProps) {
  const { limb, asked } = useLimb(room, "scan");
  const path = { params: { path: { case_id: room.id } } };
  const mode = useSignal<Mode>("photo");
  const armed = useSignal<string | null>(null);
  const chosen = useSignal<string | null>(null);
  /** A place while it is dragged. */
  const held = useSignal<{ name: string; point: Vector3 } | null>(null);
  const left = useSignal<ReadonlySet<string>>(new Set());
  const saved = useSignal("");
  const flexion = useSignal(0);
  const flipped = useSignal(false);
  const frontHere = useSignal<Vec3 | null>(null);
  /** What a hand turned since the axes were set; not kept yet. */
  const byHand = useSignal<ByHand>(STILL);
  const taken_ = useRef<ByHand | null>(null);
  const viewer = useRef<Viewer | null>(null);
  const act = useAct();
  const kind = limb?.reply.kind ?? room.info.kind ?? null;
  const side = limb?.reply.side ?? room.info.side ?? null;
  const names = useAsked(async () => (kind ? await taken(api.GET("/api/v1/templates/names/{kind}", { params: { path: { kind } } })) : []), [kind]);
  const marks = useAsked(async () => (limb && !limb.reply.aligned && limb.reply.places.length === 0 ? await taken(api.GET("/api/v1/cases/{case_id}/limb/marks", path)) : []), [limb?.reply.sha256]);

  const guesses = useAsked(async () => (limb ? await taken(api.GET("/api/v1/cases/{case_id}/limb/guesses", path)) : null), [limb?.reply.sha256, kind, limb?.reply.aligned]);
  const places = withPending(limb?.reply.places ?? [], pendingAt(room.id, PLACE));
  const known = names.value.value ?? [];
  const order = [...known.map((one) => one.name), ...places.map((one) => one.name).filter((name) => !known.some((one) => one.name === name))];
  const nextName = order.find((name) => !places.some((one) => one.name === name) && !left.value.has(name)) ?? null;
  const facing = places.filter((one) => known.find((k) => k.name === one.name && k.facing !== "none")).length;
  const aligned = limb?.reply.aligned ?? false;

  /** What may be a place and is none yet, with the name that it would have. */
  const offered = useMemo<Offered[]>(() => {
    const left_ = (guesses.value.value?.places ?? []).map((one): Offered => ({ name: one.name || (one.sticker !== null && one.sticker !== undefined ? nameOfSticker(one.sticker) : ""), sticker: one.sticker ?? null, by: one.by, at: vec3(one.position_mm) }));
    return left_.filter((one) => !places.some((p) => p.name === one.name || distance(vec3(p.position_mm), one.at) < SAME_MM));
  }, [guesses.value.value, places]);
  const guessOf = (name: string) => offered.find((one) => one.name === name) ?? null;

  // The first name is armed at once: one press on the limb is all that is asked.
  useEffect(() => {
    if (limb && !aligned && armed.value === null && places.length === 0 && nextName) armed.value = nextName;
  }, [limb, nextName]);

  const put = (name: string, point: Vector3) =>
    act.run(async () => {
      chosen.value = name;
      const kept = perform(room.id, "put", PLACE, { params: { path: { case_id: room.id, name } }, body: { placed: "click", position_mm: [point.x, point.y, point.z] } }, { done: take, again: asked.again });
      if (held.value?.name === name) held.value = null; // what is on its way to the server is shown by itself
      await kept;
      const sticker = offered.find((one) => one.sticker !== null && distance(one.at, [point.x, point.y, point.z]) < SAME_MM)?.sticker;
      if (sticker !== null && sticker !== undefined) rememberSticker(sticker, name);
      saved.value = t("align.placed", term(name));
    });
  const take = (reply: Schemas["LimbReply"]) => {
    const before = asked.value.value;
    if (before) asked.put({ ...before, reply });
  };
  const remove = (name: string) =>
    act.run(async () => {
      if (chosen.value === name) chosen.value = null;
      await perform(room.id, "delete", PLACE, { params: { path: { case_id: room.id, name } } }, { done: take, again: asked.again });
    });

  const latest = useRef({ put, offered, places, after: (_name: string): string | null => null });
  const tool = useMemo<Tool>(() => {
    let moving: string | null = null;
    const near = (event: PointerEvent): string | null => {
      const v = viewer.current;
      const box = v?.canvas.getBoundingClientRect();
      if (!v?.surface || !box) return null;
      const reach = event.pointerType === "touch" ? GRAB_TOUCH_PX : GRAB_PX;
      let found: string | null = null;
      let least = reach;
      for (const one of latest.current.places) {
        const shown = v.surface.toShown(new Vector3(...vec3(one.position_mm)));
        const p = v.toScreen(shown);
        const away = Math.hypot(p.x + box.left - event.clientX, p.y + box.top - event.clientY);
        if (away < least && v.isSeen(shown, 2)) [found, least] = [one.name, away];
      }
      return found;
    };
    /** A guess under the hand: a place that is released there is that one. */
    const caught = (point: Vector3): Vector3 => {
      const one = latest.current.offered.find((g) => distance(g.at, [point.x, point.y, point.z]) < CATCH_MM);
      return one ? new Vector3(...one.at) : point;
    };
    return {
      press(hit, event) {
        moving = near(event) ?? armed.value;
        if (!moving) return false;
        chosen.value = moving;
        held.value = { name: moving, point: caught(hit.point) };
        return true;
      },
      slide(hit) {
        if (!moving) return;
        if (hit) {
          held.value = { name: moving, point: caught(hit.point) };
          saved.value = "";
        } else saved.value = t("align.silhouette");
      },
      release() {
        const now = held.value;
        const name = moving;
        moving = null;
        if (!now || !name) return;
        void latest.current.put(name, now.point);
        if (armed.value === name) armed.value = latest.current.after(name);
      },
      cancel() {
        moving = null;
        held.value = null;
      },
    };
  }, [limb?.reply.sha256]);

  const after = (name: string): string | null => {
    const have = new Set([...places.map((one) => one.name), name]);
    const at = order.indexOf(name);
    return [...order.slice(at + 1), ...order.slice(0, at)].find((one) => !have.has(one) && !left.value.has(one)) ?? null;
  };

  latest.current = { put, offered, places, after };

  const setAxes = () =>
    act.run(async () => {
      if (!side || side === "none" ? sided(kind) : false) return;
      const body: Schemas["Align"] = {
        side: side ?? "none",
        kind,
        axis: "fit",
        proximal: limb && !aligned ? proximalGuess(limb.frame.rotation[2], flipped.value) : flipped.value && limb ? scaled(limb.frame.rotation[2], -1) : null,
        anterior: frontHere.value && [...frontHere.value],
        flexion_deg: flexion.value,
      };
      await perform(room.id, "post", "/api/v1/cases/{case_id}/limb/align", { ...path, body }, { done: take, again: asked.again });
      saved.value = t("align.done");
      flipped.value = false;
      byHand.value = STILL;
      await room.again();
      await asked.again();
    });

  /** Keep what the hand turned: the axes as they are shown are stated to the server. */
  const keepByHand = () =>
    act.run(async () => {
      if (!limb) return;
      const { rotation } = turned(limb.frame, byHand.value);
      const body: Schemas["Align"] = { side: side ?? "none", kind, axis: scaled(rotation[2], 1), anterior: scaled(rotation[1], 1), flexion_deg: 0 };
      await perform(room.id, "post", "/api/v1/cases/{case_id}/limb/align", { ...path, body }, { done: take, again: asked.again });
      byHand.value = STILL;
      saved.value = t("align.by.hand.kept");
      await room.again();
      await asked.again();
    });

  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      const v = viewer.current;
      if (event.target instanceof HTMLInputElement) return;
      if (event.key === "Escape") {
        armed.value = null;
        held.value = null;
      }
      if (event.key === "Enter" && armed.value && v && document.activeElement === v.canvas) {
        const box = v.canvas.getBoundingClientRect();
        const hit = v.hitAt(box.left + box.width / 2, box.top + box.height / 2);
        const name = armed.value;
        if (hit) {
          void put(name, hit.point);
          armed.value = after(name);
        }
        event.preventDefault();
      }
    };
    addEventListener("keydown", key);
    return () => removeEventListener("keydown", key);
  });

  /** Arrows on a row move its place over the surface: 0.5 mm, with Shift 0.1 mm. */
  const nudge = (name: string, event: KeyboardEvent) => {
    const ways: Record<string, readonly [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const way = ways[event.key];
    const one = places.find((p) => p.name === name);
    const v = viewer.current;
    if (!way || !one || !v?.surface) return;
    event.preventDefault();
    const step = event.shiftKey ? 0.1 : 0.5;
    const { right, up } = v.axes();
    const shown = v.surface.toShown(new Vector3(...vec3(one.position_mm)));
    shown.addScaledVector(right, way[0] * step).addScaledVector(up, way[1] * step);
    void put(name, v.surface.toMesh(shown));
  };

  const shown = useMemo<Shown | null>(() => (limb ? { surface: limb.fetched.data, frame: turned(limb.frame, byHand.value), aligned: limb.reply.aligned } : null), [limb, byHand.value]);
  const onAxes = (drag: ByHand, done: boolean) => {
    const from = (taken_.current ??= byHand.value);
    byHand.value = { turn_deg: tenth(from.turn_deg + drag.turn_deg), flex_deg: tenth(from.flex_deg + drag.flex_deg), lean_deg: tenth(from.lean_deg + drag.lean_deg) };
    if (done) taken_.current = null;
  };
  const drawn: Mark[] = [
    ...places.filter((one) => one.name !== held.value?.name).map((one): Mark => ({ name: one.name, label: term(one.name), point: new Vector3(...vec3(one.position_mm)), state: chosen.value === one.name ? "chosen" : "set" })),
    ...(held.value ? [{ name: held.value.name, label: term(held.value.name), point: held.value.point, state: "chosen" as const }] : []),
    ...offered.filter((one) => one.name !== held.value?.name).map((one, i): Mark => ({ name: `guess ${i}`, label: `${one.name ? term(one.name) : t("align.sticker", one.sticker ?? 0)}?`, point: new Vector3(...one.at), state: "guess" })),
    ...(places.length === 0 && !held.value ? (marks.value.value ?? []).slice(0, 12).map((one, i): Mark => ({ name: `?${i}`, label: "?", point: new Vector3(...vec3(one.position_mm)), state: "guess" })) : []),
  ];
  const lacks = !kind ? t("align.kind.first") : (!side || side === "none") && sided(kind) ? t("align.side.first") : facing === 0 && !frontHere.value ? t("align.places.first") : null;

  return (
    <div class="work">
      <Stage
        shown={shown}
        label={t("stage.limb")}
        mode={mode}
        modes={["surface", "photo", "sure"]}
        marks={drawn}
        tool={tool}
        onAxes={aligned && !armed.value ? onAxes : undefined}
        onReady={(made) => (viewer.current = made)}
        keys={aligned && !armed.value ? t("align.keys.axes") : armed.value ? t("align.keys.armed", term(armed.value)) : t("align.keys")}
      >
        <Loupe viewer={viewer} on={held.value !== null} />
        {!isStill(byHand.value) && (
          <div class="hint-card at-handle" role="status">
            <b>{handWords(byHand.value)}</b>
          </div>
        )}
        {armed.value && <p class="armed-note">{t("align.now", term(armed.value))}</p>}
        {asked.refused.value && (
          <div class="stage-note">
            <Refusal refused={asked.refused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("step.align")}>
        <h1 class="unseen">{t("step.align")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <div class="row-head">
              <h2>{aligned ? t("align.set") : t("align.title")}</h2>
              <span class="grow" />
              {aligned && <Chip tone="green">{t("align.front.set")}</Chip>}
            </div>
            <p class="soft small-note" role="status">
              {saved.value || (aligned ? t("align.set.how") : t("align.how"))}
            </p>
            <Refusal refused={act.refused.value ?? names.refused.value} />
            {!kind && <KindAndSide room={room} onDone={() => void Promise.all([room.again(), asked.again()])} />}
            {kind && !side && <KindAndSide room={room} onDone={() => void Promise.all([room.again(), asked.again()])} />}
          </section>
          <section class="tab">
            <ul class="places-list">
              {order.map((name) => {
                const one = places.find((p) => p.name === name);
                const on = armed.value === name || chosen.value === name;
                return (
                  <li key={name} class={`${on ? "on" : ""} ${one ? "placed" : ""} ${left.value.has(name) ? "left-out" : ""}`}>
                    <button
                      type="button"
                      class="place-row"
                      aria-pressed={armed.value === name}
                      onKeyDown={(event) => nudge(name, event)}
                      onClick={() => {
                        if (one) {
                          chosen.value = name;
                          armed.value = null;
                          const v = viewer.current;
                          if (v?.surface) v.lookAt(new Vector3(...vec3(one.position_mm)), normalNear(v, new Vector3(...vec3(one.position_mm))));
                        } else {
                          armed.value = armed.value === name ? null : name;
                          left.value = new Set([...left.value].filter((n) => n !== name));
                        }
                      }}
                    >
                      <span class={`mark ${one ? "set" : armed.value === name ? "now" : ""}`} aria-hidden="true">
                        {one ? <Icon name="tick" small /> : null}
                      </span>
                      <span class="grow">{term(name)}</span>
                      <span class="num faint small">
                        {guessOf(name) && !one && armed.value !== name ? t(`align.guess.${guessOf(name)?.by ?? "shape"}`) : one ? (one.within_mm ? `± ${one.within_mm.toFixed(2)} mm` : "") : armed.value === name ? t("align.press") : left.value.has(name) ? t("align.left") : facingWord(known.find((k) => k.name === name)?.facing)}
                      </span>
                    </button>
                    {!one && guessOf(name) && armed.value !== name ? (
                      <Button
                        bare
                        onClick={() => {
                          const guess = guessOf(name);
                          if (guess) void put(name, new Vector3(...guess.at));
                        }}
                        label={t("align.guess.confirm.long", term(name))}
                      >
                        {t("align.guess.confirm")}
                      </Button>
                    ) : one ? (
                      <Button bare icon="close" class="icon-only" label={t("align.remove", term(name))} onClick={() => void remove(name)} />
                    ) : (
                      armed.value === name && (
                        <Button
                          bare
                          onClick={() => {
                            left.value = new Set([...left.value, name]);
                            armed.value = after(name);
                          }}
                        >
                          {t("align.leave")}
                        </Button>
                      )
                    )}
                    {expert.value && one?.in_limb_mm && <span class="mono xyz">{one.in_limb_mm.map((v) => v.toFixed(1)).join(" ")}</span>}
                  </li>
                );
              })}
            </ul>
          </section>
          <section>
            <h3>{t("align.axis")}</h3>
            <div class="setting">
              <span>{t("align.front")}</span>
              <Segments
                label={t("align.front")}
                value={frontHere.value ? "look" : "places"}
                options={[
                  { value: "places", text: t("align.front.places") },
                  { value: "look", text: t("align.front.look") },
                ]}
                onChange={(value) => {
                  const v = viewer.current;
                  if (value === "places" || !v?.surface) frontHere.value = null;
                  else {
                    const origin = v.surface.toMesh(new Vector3());
                    const tip = v.surface.toMesh(v.axes().back);
                    const d = tip.sub(origin);
                    frontHere.value = [d.x, d.y, d.z];
                  }
                }}
              />
            </div>
            <div class="setting">
              <span>{t("align.up")}</span>
              <Segments label={t("align.up")} value={flipped.value ? "down" : "up"} options={[{ value: "up", text: t("align.up.as") }, { value: "down", text: t("align.up.turn") }]} onChange={(value) => (flipped.value = value === "down")} />
            </div>
            {aligned ? (
              <>
                <h3>{t("align.by.hand")}</h3>
                <p class="small faint">{t("align.by.hand.how")}</p>
                <div class="row3">
                  <NumberField label={t("align.turn")} unit="°" step={0.5} decimals={1} min={-180} max={180} value={byHand.value.turn_deg} onChange={(turn_deg) => (byHand.value = { ...byHand.value, turn_deg })} />
                  <NumberField label={t("align.flex")} unit="°" step={0.5} decimals={1} min={-60} max={60} value={byHand.value.flex_deg} onChange={(flex_deg) => (byHand.value = { ...byHand.value, flex_deg })} />
                  <NumberField label={t("align.lean")} unit="°" step={0.5} decimals={1} min={-60} max={60} value={byHand.value.lean_deg} onChange={(lean_deg) => (byHand.value = { ...byHand.value, lean_deg })} />
                </div>
              </>
            ) : (
              <NumberField label={t("align.flexion")} unit="°" step={1} decimals={1} min={-120} max={120} value={flexion.value} onChange={(value) => (flexion.value = value)} />
            )}
            {aligned && limb && (
              <p class="small faint" style={{ marginTop: "8px" }}>
                {t("align.size", ...limb.reply.size_mm.map((v) => v.toFixed(1)))}
              </p>
            )}
            {limb?.reply.notes.map((one) => (
              <Notice key={said(one)} tone="amber" title={said(one)} />
            ))}
          </section>
        </div>
        <div class="next">
          {!isStill(byHand.value) ? (
            <>
              <Button go big off={act.busy.value && t("loading")} onClick={() => void keepByHand()}>
                {t("align.by.hand.keep")}
              </Button>
              <p>
                <button type="button" class="linkish" onClick={() => (byHand.value = STILL)}>
                  {t("drop.edit")}
                </button>
              </p>
            </>
          ) : aligned && !flipped.value && !frontHere.value ? (
            <>
              <Button go big trailing="next" onClick={() => go(href.step(room.id, "measure"))}>
                {t("result.next.measure")}
              </Button>
              <p>
                <button type="button" class="linkish" onClick={() => void setAxes()}>
                  {t("align.again")}
                </button>
              </p>
            </>
          ) : (
            <>
              <Button go big off={lacks} onClick={() => void setAxes()}>
                {t("align.confirm")}
              </Button>
              {lacks && <p class="small soft">{lacks}</p>}
            </>
          )}
        </div>
      </aside>
    </div>
  );
}

/** A place that is guessed; a sticker has no name until one was placed on it once. */
interface Offered {
  readonly name: string;
  readonly sticker: number | null;
  readonly by: "shape" | "sticker";
  readonly at: Vec3;
}

/** The places once the acts that are pending are done. */
function withPending(kept: readonly Schemas["Place"][], acts: readonly Act[]): readonly Schemas["Place"][] {
  let places = kept;
  for (const { method, init } of acts) {
    const name = String(init.params?.path?.["name"]);
    const others = places.filter((one) => one.name !== name);
    places = method === "delete" ? others : [...others, { name, ...(init.body as Schemas["PlaceMark"]) }];
  }
  return places;
}

const tenth = (deg: number) => Math.round(10 * deg) / 10;

/** What the hand turned, each way in words with its degrees. */
function handWords(by: ByHand): string {
  const rows: readonly [number, string, string][] = [
    [by.turn_deg, t("align.turned.left"), t("align.turned.right")],
    [by.flex_deg, t("align.flexed.back"), t("align.flexed.front")],
    [by.lean_deg, t("align.leaned.right"), t("align.leaned.left")],
  ];
  return rows
    .filter(([deg]) => deg !== 0)
    .map(([deg, plus, minus]) => `${Math.abs(deg).toFixed(1)}° ${deg > 0 ? plus : minus}`)
    .join(", ");
}

const facingWord = (facing: string | undefined) => (facing && facing !== "none" ? tOr(`facing.${facing}`, facing) : "");
const scaled = (v: Vec3, s: number): [number, number, number] => [v[0] * s, v[1] * s, v[2] * s];
const proximalGuess = (z: Vec3, flipped: boolean) => scaled(z, flipped ? -1 : 1);

/** The normal of the surface near a point, to look straight at it. */
function normalNear(v: Viewer, point: Vector3): Vector3 {
  const surface = v.surface;
  if (!surface) return new Vector3(0, 0, 1);
  const at = surface.positions;
  let best = 0;
  let least = Infinity;
  for (let i = 0; i < at.length; i += 3) {
    const d = (at[i] - point.x) ** 2 + (at[i + 1] - point.y) ** 2 + (at[i + 2] - point.z) ** 2;
    if (d < least) [best, least] = [i, d];
  }
  return new Vector3(surface.normals[best], surface.normals[best + 1], surface.normals[best + 2]);
}

function KindAndSide({ room, onDone }: RoomProps & { onDone: () => void }) {
  const act = useAct();
  const change = (body: Schemas["CaseChange"]) =>
    act.run(async () => {
      await perform(room.id, "patch", "/api/v1/cases/{case_id}", { params: { path: { case_id: room.id } }, body });
      onDone();
    });
  return (
    <div class="asks">
      {!room.info.kind && (
        <>
          <h3>{t("cases.which.kind")}</h3>
          <div class="choices">
            {limbKinds.value.map((one) => (
              <Button key={one.kind} onClick={() => void change({ kind: one.kind })}>
                {kindName(one.kind)}
              </Button>
            ))}
          </div>
        </>
      )}
      {!room.info.side && sided(room.info.kind) && (
        <>
          <h3>{t("cases.which.side")}</h3>
          <div class="choices">
            {(["right", "left"] as const).map((one) => (
              <Button key={one} onClick={() => void change({ side: one })}>
                {t(`side.${one}`)}
              </Button>
            ))}
          </div>
        </>
      )}
      <Refusal refused={act.refused.value} />
    </div>
  );
}

