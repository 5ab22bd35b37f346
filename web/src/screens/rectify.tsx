/**
 * Rectify: what changes, by how much? Regions are drawn and depths dragged on the limb; the recipe is
 * the list of what can be undone.
 *
 * While a hand drags, this page shows its own preview. After release the server tries the edit, and
 * what is shown then is what will be made. Kept edits stand in the recipe, which the server replays;
 * until it has answered, an edit that is being kept stays open and holds still.
 */
import { signal, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { Vector3 } from "three";

import { type Schemas, Refused, api, bytesOf, taken } from "../api/client";
import { changedBy, decodeBlocks } from "../api/blocks";
import { Icon, type IconName } from "../design/icons";
import { Button, Notice, NumberField, Segments, Switch } from "../design/parts";
import { Refusal } from "../design/refusal";
import { type Neighbours, type Shares, neighboursOf, ring, sharesAtPlace, sharesInRegion } from "../geometry/edit";
import { signed, widthFor } from "../geometry/scales";
import { cut, heightsOf } from "../geometry/section";
import { type Vec3, apply, distance, vec3 } from "../geometry/vectors";
import { newOffer, perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { fetchDifferences } from "../state/shapes";
import { type TextKey, t } from "../texts";
import type { Line, Mark } from "../viewer/overlay";
import { Stage, type Shown } from "../viewer/stage";
import type { Hit, Mode, SurfaceData } from "../viewer/surface";
import type { Tool, Viewer } from "../viewer/viewer";
import { type Finding, term } from "../words";
import { askedBy, said, scanWords, wordsOf } from "./edit-words";
import { OtherEdit } from "./other-edit";
import { TemplateEdits } from "./templates";
import { useLimb } from "./limb";
import { EDIT, EDITS, RECIPE, type Shown as ShownEdit, afterActs, recipeActs, seenBy } from "./recipe-acts";
import type { RoomProps } from "./room";

type ToolName = "place" | "region" | "brush" | "levels" | "trimline" | "template" | "other";
type Ledgered = Schemas["Ledgered"];

/** An edit that is open: drawn and dragged, not kept. */
interface Draft {
  readonly kind: "load" | "relieve";
  readonly depth_mm: number;
  readonly falloff_mm: number;
  readonly flat_mm: number;
  /** A landmark's name, or a place in the mesh's frame. */
  readonly at: string | Vec3 | null;
  readonly within: readonly Vec3[];
  readonly anchor: Vec3;
  readonly normal: Vec3;
  readonly seed: number;
  readonly accept: readonly string[];
}

/** The edit by numbers with which the screen opens, where another one sends somebody here for it. */
export const openWith = signal<"wall" | null>(null);
const SNAP_MM = 0.5;
const ASK_BEYOND_MM = 8;
const MOST_POINTS = 48;
const CLOSE_PX = 14;
const APART_MM = 1;
/** Points round the limb that make a trimline. */
const LEAST_TRIM = 4;
/** The server draws a smooth line through the points, which may leave the limb between far ones. */
const TRIM_APART_MM = 25;
/** Pieces into which a trimline is parted between two points, so that it lies on the surface. */
const GLUED = 10;
const TOOLS: readonly { name: ToolName; icon: IconName }[] = [
  { name: "place", icon: "place" },
  { name: "region", icon: "region" },
  { name: "brush", icon: "brush" },
  { name: "levels", icon: "levels" },
  { name: "trimline", icon: "trimline" },
  { name: "template", icon: "template" },
  { name: "other", icon: "more" },
];

export function RectifyScreen({ room }: RoomProps) {
  const { limb, asked } = useLimb(room, "rectified");
  const path = { params: { path: { case_id: room.id } } };
  const mode = useSignal<Mode>("difference");
  const level = useSignal<number | null>(null);
  /** Asked once: what the screen was opened for. */
  const first = useMemo(() => openWith.value, []);
  const tool = useSignal<ToolName>(first ? "other" : "region");
  useEffect(() => void (openWith.value = null), []);
  const draft = useSignal<Draft | null>(null);
  const drawing = useSignal<readonly Vector3[]>([]);
  const trial = useSignal<{ surface: SurfaceData; values: Float32Array; line: Schemas["LineReply"] | null } | null>(null);
  const trimline = useSignal<readonly Vector3[]>([]);
  const trimClosed = useSignal(false);
  const size = useSignal(14);
  /** Of the brush: how wide its edge falls off. */
  const soft = useSignal(8);
  /** Where the brush would touch the limb now. */
  const over = useSignal<Hit | null>(null);
  /** Counts what this page moved itself, so that the girth follows the hand. */
  const previewed = useSignal(0);
  const waits = useSignal(false);
  const refused = useSignal<Refused | null>(null);
  const asksDepth = useSignal(false);
  /** The edit before which the shape is the one that colours are against; null: the scan. */
  const againstEdit = useSignal<number | null>(null);
  const chosenRow = useSignal<number | null>(null);
  const act = useAct();
  /** The edit that is open is being kept. */
  const keeping = useSignal(false);
  /** Of the edit that is open, as it is now: kept twice it is in the recipe once. */
  const offer = useMemo(newOffer, []);
  const viewer = useRef<Viewer | null>(null);
  const turn = useRef(0);

  const ledgered = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/recipe/ledger", path)), [room.id, room.news.work]);
  const book = ledgered.value.value;
  const going = recipeActs(room.id);
  const listed = book && afterActs(book.recipe.edits, going);
  // An edit that was taken out has no state before it: then the colours are against the scan again.
  const before = againstEdit.value !== null && againstEdit.value <= (book?.recipe.edits.length ?? 0) ? againstEdit.value : null;
  const asks = `${limb?.fetched.tag} ${before}`;
  const differences = useAsked(async () => ({ values: await fetchDifferences(room.id, before), of: asks }), [room.id, asks]);
  const base = limb?.fetched.data ?? null;
  const near = useMemo<Neighbours | null>(() => (base ? neighboursOf(base.positions.length / 3, base.indices) : null), [base]);
  /** What the trial showed of an edit that is kept: the same shape, until the server's own map is here. */
  const carried = useRef<Float32Array | null>(null);
  const baseDifferences = useMemo(() => {
    const count = base ? base.positions.length / 3 : 0;
    const found = differences.value.value;
    const own = found?.of === asks ? found.values : null;
    return [own, carried.current, found?.values].find((values) => values?.length === count) ?? new Float32Array(count);
  }, [differences.value.value, base, asks]);
  const d = draft.value;
  const shares = useMemo<Shares | null>(() => {
    if (!d || !base || !near) return null;
    return d.within.length ? sharesInRegion(base.positions, near, d.within, d.seed, d.falloff_mm) : sharesAtPlace(base.positions, near, d.seed, d.anchor, d.flat_mm, d.falloff_mm);
  }, [d?.within, d?.anchor, d?.falloff_mm, d?.flat_mm, d?.seed, base, near]);
  const areas = useMemo(() => (base && shares ? areasOf(base, shares) : null), [base, shares]);

  const shown = useMemo<Shown | null>(() => {
    if (!limb) return null;
    const values = trial.value?.values ?? baseDifferences;
    return { surface: trial.value?.surface ?? limb.fetched.data, frame: limb.frame, aligned: limb.reply.aligned, difference: { values, wider: widest(values) } };
  }, [limb, trial.value, baseDifferences]);

  const sign = d?.kind === "load" ? -1 : 1;

  /** Move the surface on this page only, while the hand drags. */
  const previewHere = (next: Draft) => {
    const v = viewer.current;
    if (!v?.surface || !base || !shares) return;
    if (v.surface.data !== base) return;
    const way = next.kind === "load" ? -1 : 1;
    const { vertices, shares: part } = shares;
    const moved = new Float32Array(3 * vertices.length);
    const values = baseDifferences.slice();
    const normals = baseNormals.current?.data === base ? baseNormals.current.normals : (baseNormals.current = { data: base, normals: v.surface.normals.slice() }).normals;
    for (let i = 0; i < vertices.length; i++) {
      const by = way * next.depth_mm * part[i];
      const k = 3 * vertices[i];
      for (let c = 0; c < 3; c++) moved[3 * i + c] = base.positions[k + c] + by * normals[k + c];
      values[vertices[i]] += by;
    }
    v.surface.move(vertices, moved);
    previewed.value += 1;
    v.surface.showDifference(values, widest(values));
    v.draw();
  };
  const baseNormals = useRef<{ data: SurfaceData; normals: Float32Array } | null>(null);

  /** Ask the server what the edit would do; its answer takes the place of this page's preview. */
  const tryOut = (next: Draft) => tryEdit(edit(next));
  const tryEdit = async (body: { kind: string; parameters: Record<string, unknown>; accept: string[] }) => {
    const mine = ++turn.current;
    waits.value = true;
    refused.value = null;
    try {
      const { bytes } = await bytesOf(`/cases/${room.id}/recipe/preview`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
      if (mine !== turn.current || !limb || !base) return;
      const v = viewer.current;
      if (v?.surface && v.surface.data === base) baseSurface.current = v.surface;
      const blocks = decodeBlocks(bytes);
      const surface = changedBy(base, blocks);
      trial.value = { surface, values: trialDifferences(surface, base), line: (blocks.header.line as Schemas["LineReply"] | null) ?? null };
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      if (mine === turn.current) {
        refused.value = error;
        trial.value = null;
      }
    } finally {
      if (mine === turn.current) waits.value = false;
    }
  };
  const baseSurface = useRef<Viewer["surface"]>(null);
  const trialDifferences = (surface: SurfaceData, from: SurfaceData): Float32Array => {
    const count = surface.positions.length / 3;
    const values = new Float32Array(count);
    const old = from.positions.length / 3;
    const s = baseSurface.current?.data === from ? baseSurface.current : null;
    // What this page moved for its own preview goes back: distances count from the shape as it is.
    s?.restore();
    const p = new Vector3();
    for (let i = 0; i < count; i++) {
      const k = 3 * i;
      const same = i < old && surface.positions[k] === from.positions[k] && surface.positions[k + 1] === from.positions[k + 1] && surface.positions[k + 2] === from.positions[k + 2];
      if (same) values[i] = baseDifferences[i];
      else if (s) {
        const found = s.signedDistance(p.set(surface.positions[k], surface.positions[k + 1], surface.positions[k + 2]));
        values[i] = (baseDifferences[found.vertex] ?? 0) + found.signed_mm;
      }
    }
    return values;
  };

  const open = (next: Draft) => {
    if (keeping.value) return;
    draft.value = next;
    trial.value = null;
    drawing.value = [];
    level.value = limb ? Math.round(apply(limb.frame, next.anchor)[2]) : null;
    void tryOut(next);
  };
  /** Try an edit that is not drawn on the limb. */
  const tryNew = (body: { kind: string; parameters: Record<string, unknown>; accept: string[] }) => {
    if (!keeping.value) void tryEdit(body);
  };
  const change = (part: Partial<Draft>) => {
    if (!draft.value || keeping.value) return;
    const next = { ...draft.value, ...part };
    draft.value = next;
    void tryOut(next);
  };
  const drop = () => {
    if (keeping.value) return;
    turn.current++;
    offer.over();
    draft.value = null;
    trial.value = null;
    drawing.value = [];
    trimline.value = [];
    trimClosed.value = false;
    refused.value = null;
    waits.value = false;
    const v = viewer.current;
    if (v?.surface && base && v.surface.data === base) {
      v.surface.restore();
      v.surface.showDifference(baseDifferences, widest(baseDifferences));
      v.draw();
    }
  };
  const edit = (one: Draft) => ({
    kind: one.kind,
    parameters: {
      depth_mm: one.depth_mm,
      falloff_mm: one.falloff_mm,
      ...(one.within.length ? { within: one.within.map((p) => [...p]), positions_in: "mesh" } : { at: typeof one.at === "string" ? one.at : [...(one.at ?? one.anchor)], flat_mm: one.flat_mm, ...(typeof one.at === "string" ? {} : { positions_in: "mesh" }) }),
    },
    accept: [...one.accept],
  });
  /** Any change of the recipe: the ledger comes back, then the shape. */
  const recipe = (call: (query: { seen?: string }) => Promise<unknown>) =>
    act.run(async () => {
      try {
        await call({ seen: seenBy(recipeActs(room.id), book?.recipe.mark) });
      } catch (error) {
        if (error instanceof Refused && error.status === 409) void ledgered.again();
        throw error;
      }
      await asked.again();
      await room.again();
    });
  const took = (answer: Ledgered) => {
    carried.current = null;
    ledgered.put(answer);
  };
  const tookAnew = async () => {
    await ledgered.again();
    carried.current = null;
  };
  /** Whether this very edit was kept: one is kept after the other. */
  const add = async (body: { kind: string; parameters: Record<string, unknown>; accept: string[] }): Promise<boolean> => {
    if (keeping.value) return false;
    keeping.value = true;
    const after = (tried: Float32Array | null) => {
      carried.current = tried;
      keeping.value = false;
      drop();
    };
    const done = (answer: Ledgered) => {
      const tried = trial.value?.values ?? null;
      took(answer);
      after(tried);
    };
    const again = () => tookAnew().then(() => after(null));
    const added = await recipe(() => perform(room.id, "post", EDITS, { ...path, body }, { id: offer.idOf(body), done, again }));
    keeping.value = false;
    return added !== null;
  };
  const keep = () => {
    const now = draft.value;
    if (now) void add(edit(now));
  };
  const undo = () => recipe((query) => perform(room.id, "post", `${RECIPE}/undo`, { params: { ...path.params, query } }, { done: took, again: tookAnew }));
  const redo = () => recipe((query) => perform(room.id, "post", `${RECIPE}/redo`, { params: { ...path.params, query } }, { done: took, again: tookAnew }));
  const changeEdit = (number: number, body: Schemas["EditChange"]) => recipe((query) => perform(room.id, "patch", EDIT, { params: { path: { case_id: room.id, number }, query }, body }, { done: took, again: tookAnew }));
  const removeEdit = (number: number) => recipe((query) => perform(room.id, "delete", EDIT, { params: { path: { case_id: room.id, number }, query } }, { done: took, again: tookAnew }));
  // A change elsewhere made another shape under the edit that is open: it is tried again, on that one.
  useEffect(() => {
    const now = draft.value;
    if (!now || !base || keeping.value) return;
    trial.value = null;
    draft.value = { ...now, seed: nearest(base, now.anchor) };
    void tryOut(draft.value);
  }, [base]);

  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
      if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !typing) {
        event.preventDefault();
        void (event.shiftKey ? redo() : undo());
      } else if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "y" && !typing) {
        event.preventDefault();
        void redo();
      } else if (event.key === "Escape") drop();
      else if (event.key === "Enter" && draft.value && !typing && !(event.target instanceof HTMLButtonElement)) keep();
      else if (event.key === "Backspace" && !typing && trimline.value.length) {
        trimClosed.value = false;
        trimline.value = trimline.value.slice(0, -1);
      } else if (event.key === "[" && !typing) size.value = Math.max(4, size.value - 1);
      else if (event.key === "]" && !typing) size.value = Math.min(60, size.value + 1);
      else if (event.key === ";" && !typing) soft.value = Math.max(1, soft.value - 1);
      else if (event.key === "'" && !typing) soft.value = Math.min(60, soft.value + 1);
    };
    // The wheel with Alt is the brush's size, before the canvas takes it for coming nearer.
    const wheel = (event: WheelEvent) => {
      if (!event.altKey || tool.value !== "brush" || event.target !== viewer.current?.canvas) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      size.value = Math.max(4, Math.min(60, size.value - Math.sign(event.deltaY || event.deltaX)));
    };
    addEventListener("keydown", key);
    addEventListener("wheel", wheel, { capture: true, passive: false });
    return () => {
      removeEventListener("keydown", key);
      removeEventListener("wheel", wheel, { capture: true });
    };
  });
  useEffect(() => {
    const v = viewer.current;
    if (!v) return;
    v.onHover = tool.value === "brush" && !d ? (hit) => (over.value = hit) : null;
    over.value = null;
  }, [tool.value, d === null, limb]);

  // The tool is made once a kind; what it calls is that of the latest render.
  const latest = useRef({ open, limb, draft, closeRegion, strokeRegion, knotAt, withPoint });
  latest.current = { open, limb, draft, closeRegion, strokeRegion, knotAt, withPoint };
  const hands = useMemo<Tool | null>(() => {
    const what = tool.value;
    if (what === "levels" || what === "template" || what === "other") return null;
    let path_: { point: Vector3; x: number; y: number; hit: Hit }[] = [];
    /** Which point of the trimline is dragged. */
    let dragged: number | null = null;
    const fresh = (hit: Hit, part: Partial<Draft>): Draft => ({
      kind: latest.current.draft.value?.kind ?? "load",
      depth_mm: 2,
      falloff_mm: size.value,
      flat_mm: 0,
      at: null,
      within: [],
      anchor: [hit.point.x, hit.point.y, hit.point.z],
      normal: [hit.normal.x, hit.normal.y, hit.normal.z],
      seed: hit.vertex,
      accept: [],
      ...part,
    });
    return {
      press(hit, event) {
        path_ = [{ point: hit.point, x: event.clientX, y: event.clientY, hit }];
        if (what === "trimline") dragged = latest.current.knotAt(event);
        return true;
      },
      slide(hit, event) {
        if (hit && what === "trimline" && dragged !== null) trimline.value = trimline.value.map((p, i) => (i === dragged ? hit.point : p));
        if (!hit || what === "place" || what === "trimline") return;
        const last = path_[path_.length - 1];
        if (Math.hypot(event.clientX - last.x, event.clientY - last.y) < 5) return;
        path_.push({ point: hit.point, x: event.clientX, y: event.clientY, hit });
        drawing.value = path_.map((one) => one.point);
      },
      release(hit) {
        const first = path_[0];
        if (!first) return;
        if (what === "place") {
          const one = hit ?? first.hit;
          const named = (latest.current.limb?.reply.places ?? []).find((p) => Math.hypot(p.position_mm[0] - one.point.x, p.position_mm[1] - one.point.y, p.position_mm[2] - one.point.z) < 6);
          const anchor: Vec3 = named ? vec3(named.position_mm) : [one.point.x, one.point.y, one.point.z];
          latest.current.open(fresh(one, { at: named?.name ?? anchor, anchor }));
        } else if (what === "trimline") {
          if (dragged === 0 && trimline.value.length >= LEAST_TRIM) trimClosed.value = true;
          else if (dragged === null) trimline.value = latest.current.withPoint(first.point, first.x, first.y);
          dragged = null;
        } else {
          const v = viewer.current;
          const points = path_.length < 8 ? [] : path_;
          if (!points.length || !v) {
            // Single clicks give the corners of a region, one after the other; the first closes it.
            if (what === "brush") {
              latest.current.open(fresh(first.hit, { at: [first.point.x, first.point.y, first.point.z], flat_mm: Math.max(0, size.value - soft.value), falloff_mm: Math.min(soft.value, size.value) }));
              return;
            }
            const corners = corner.current;
            const start = corners[0];
            if (start && corners.length > 2 && Math.hypot(start.x - first.x, start.y - first.y) < CLOSE_PX) {
              corner.current = [];
              latest.current.closeRegion(corners, fresh);
            } else {
              corner.current = [...corners, first];
              drawing.value = corner.current.map((one) => one.point);
            }
            return;
          }
          if (what === "brush") latest.current.strokeRegion(v, points, fresh);
          else latest.current.closeRegion(points, fresh);
        }
      },
      cancel() {
        path_ = [];
        dragged = null;
        drawing.value = [];
      },
    };
  }, [tool.value]);
  const corner = useRef<{ point: Vector3; x: number; y: number; hit: Hit }[]>([]);

  function closeRegion(points: readonly { point: Vector3; hit: Hit }[], fresh: (hit: Hit, part: Partial<Draft>) => Draft): void {
    const step = Math.max(1, Math.ceil(points.length / MOST_POINTS));
    const line = apart(points.filter((_, i) => i % step === 0).map((one): Vec3 => [one.point.x, one.point.y, one.point.z]));
    const inside = middleOf(line);
    if (!inside) {
      drawing.value = [];
      return;
    }
    latest.current.open(fresh(points[0].hit, { within: line, ...inside, falloff_mm: tool.value === "brush" ? Math.max(1, Math.min(soft.value, inside.reach)) : Math.max(4, Math.min(size.value, inside.reach * 0.8)) }));
  }

  function onScreen(point: Vector3): readonly [number, number] | null {
    const v = viewer.current;
    if (!v?.surface) return null;
    const shown = v.surface.toShown(point);
    const box = v.canvas.getBoundingClientRect();
    const at = v.toScreen(shown);
    return v.isSeen(shown) ? [at.x + box.left, at.y + box.top] : null;
  }

  /** The point of the trimline under a pointer. */
  function knotAt(event: PointerEvent): number | null {
    const reach = event.pointerType === "touch" ? 2 * CLOSE_PX : CLOSE_PX;
    let [best, least] = [null as number | null, reach];
    trimline.value.forEach((point, i) => {
      const at = onScreen(point);
      const gap = at ? Math.hypot(at[0] - event.clientX, at[1] - event.clientY) : Infinity;
      if (gap < least) [best, least] = [i, gap];
    });
    return best;
  }

  /** The trimline with one point more: on the line where that was clicked, else at its end. */
  function withPoint(point: Vector3, x: number, y: number): readonly Vector3[] {
    const line = trimline.value;
    let [after, least] = [-1, CLOSE_PX / 2];
    const joins = trimClosed.value ? line.length : line.length - 1;
    for (let i = 0; i < joins; i++)
      for (const p of glued([line[i], line[(i + 1) % line.length]], false)) {
        const at = onScreen(p);
        const gap = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
        if (gap < least) [after, least] = [i, gap];
      }
    return after >= 0 ? [...line.slice(0, after + 1), point, ...line.slice(after + 1)] : [...line, point];
  }

  /** A line through points that lies on the surface between them: round the long axis, then to the nearest point. */
  function glued(points: readonly Vector3[], closed: boolean): Vector3[] {
    const surface = viewer.current?.surface;
    if (!surface || points.length < 2) return [...points];
    const shown = points.map((p) => surface.toShown(p));
    const made: Vector3[] = [];
    for (let i = 0; i < (closed ? points.length : points.length - 1); i++) {
      const [a, b] = [shown[i], shown[(i + 1) % points.length]];
      const [from, to] = [Math.atan2(a.y, a.x), Math.atan2(b.y, b.x)];
      const turn = Math.atan2(Math.sin(to - from), Math.cos(to - from));
      const [ra, rb] = [Math.hypot(a.x, a.y), Math.hypot(b.x, b.y)];
      for (let k = 0; k < GLUED; k++) {
        const s = k / GLUED;
        const angle = from + s * turn;
        const r = ra + s * (rb - ra);
        const near = new Vector3(r * Math.cos(angle), r * Math.sin(angle), a.z + s * (b.z - a.z));
        made.push(k === 0 ? points[i] : surface.nearest(surface.toMesh(near)));
      }
    }
    if (!closed) made.push(points[points.length - 1]);
    return made;
  }

  /** The points that are sent: those picked, and between far ones others of the line that is drawn. */
  function alongTrimline(): Vector3[] {
    const line = glued(trimline.value, true);
    return trimline.value.flatMap((_, i) => {
      const piece = line.slice(GLUED * i, GLUED * (i + 1));
      const end = line[(GLUED * (i + 1)) % line.length];
      const length_mm = piece.reduce((sum, p, k) => sum + p.distanceTo(piece[k + 1] ?? end), 0);
      const parts = Math.min(GLUED, Math.max(1, Math.ceil(length_mm / TRIM_APART_MM)));
      return Array.from({ length: parts }, (_, k) => piece[Math.round((k * GLUED) / parts)]);
    });
  }

  /** A stroke becomes the region round it, half its size wide on each side. */
  function strokeRegion(v: Viewer, points: readonly { x: number; y: number; hit: Hit; point: Vector3 }[], fresh: (hit: Hit, part: Partial<Draft>) => Draft): void {
    const half = size.value / v.mmPerPixel();
    const side = (way: number) =>
      points.map((p, i) => {
        const a = points[Math.max(0, i - 2)];
        const b = points[Math.min(points.length - 1, i + 2)];
        const far = Math.hypot(b.x - a.x, b.y - a.y) || 1;
        return [p.x - (way * half * (b.y - a.y)) / far, p.y + (way * half * (b.x - a.x)) / far] as const;
      });
    const outline = [...side(1), ...side(-1).reverse()];
    const hits = outline.map(([x, y]) => v.hitAt(x, y)).filter((one): one is Hit => one !== null);
    if (hits.length < 6) return;
    closeRegion(
      hits.map((hit) => ({ point: hit.point, hit })),
      fresh,
    );
  }

  /** A vertex inside a closed line, with its normal. */
  function middleOf(line: readonly Vec3[]): { anchor: Vec3; normal: Vec3; seed: number; reach: number } | null {
    const v = viewer.current;
    if (!v?.surface || line.length < 4 || !base) return null;
    const area = ring(line);
    let seed = -1;
    let deepest = 0;
    let least = Infinity;
    for (let i = 0; i < base.positions.length; i += 3) {
      const gap = Math.hypot(base.positions[i] - area.centre[0], base.positions[i + 1] - area.centre[1], base.positions[i + 2] - area.centre[2]);
      if (gap < least && area.isInside([base.positions[i], base.positions[i + 1], base.positions[i + 2]])) [seed, least] = [i / 3, gap];
    }
    if (seed < 0) return null;
    const anchor: Vec3 = [base.positions[3 * seed], base.positions[3 * seed + 1], base.positions[3 * seed + 2]];
    deepest = area.distance(anchor);
    return { anchor, normal: [v.surface.normals[3 * seed], v.surface.normals[3 * seed + 1], v.surface.normals[3 * seed + 2]], seed, reach: deepest };
  }

  const onHandle = (depth_mm: number, done: boolean, fine: boolean) => {
    const now = draft.value;
    const v = viewer.current;
    if (!now || !v || keeping.value) return;
    // The handle goes along the normal: outwards builds up, inwards carves in.
    const outward = depth_mm;
    const size_ = fine ? Math.abs(outward) : Math.round(Math.abs(outward) / SNAP_MM) * SNAP_MM;
    const next: Draft = { ...now, kind: outward < 0 ? "load" : "relieve", depth_mm: Number(size_.toFixed(2)) };
    if (trial.value) {
      turn.current++;
      trial.value = null;
    }
    draft.value = next;
    previewHere(next);
    if (!done) return;
    if (next.depth_mm === 0) drop();
    else if (next.depth_mm > ASK_BEYOND_MM && now.depth_mm <= ASK_BEYOND_MM) {
      asksDepth.value = true;
      void tryOut(next);
    } else void tryOut(next);
  };
  // Until the server has answered, and after its answer was taken away, the base is moved here.
  useEffect(() => {
    if (draft.value && !trial.value) previewHere(draft.value);
  }, [trial.value, shares]);

  const baseHeights = useMemo(() => (limb && base ? heightsOf(base.positions, limb.frame) : null), [limb, base]);
  const girthBefore = useMemo(() => (limb && base && baseHeights && level.value !== null ? cut(base.positions, base.indices, baseHeights, level.value, limb.frame).tape_mm : NaN), [limb, base, baseHeights, level.value]);
  // Of the server's answer; while the hand drags, of what this page moved.
  const girthHere = useMemo(() => {
    if (!limb || level.value === null || !base) return null;
    const moved = draft.value && viewer.current?.surface?.data === base ? viewer.current.surface.positions : base.positions;
    const { positions, indices } = trial.value?.surface ?? { positions: moved, indices: base.indices };
    const now = positions === base.positions ? girthBefore : cut(positions, indices, heightsOf(positions, limb.frame), level.value, limb.frame).tape_mm;
    return Number.isFinite(now) ? { now, change: now - girthBefore } : null;
  }, [limb, level.value, trial.value, base, girthBefore, draft.value, previewed.value]);
  const line = trial.value?.line ?? null;
  const volume = line ? changed(line.volume) : areas !== null && d ? (sign * areas * d.depth_mm) / 1000 : null;
  const unsaid = askedBy(refused.value?.finding ?? null);

  /** An edit that is drawn and not kept: leaving the page would lose it. */
  const open_ = d !== null || trimline.value.length > 0;

  const trimDrawn = useMemo(() => {
    const line = glued(trimline.value, trimClosed.value);
    return trimClosed.value ? [...line, trimline.value[0]] : line;
  }, [trimline.value, trimClosed.value, limb]);
  const rings = over.value && !drawing.value.length ? [size.value, size.value - soft.value].filter((radius) => radius > 0.5).map((radius) => ringOn(over.value as Hit, radius)) : [];
  const drawn: Line[] = [
    ...rings.map((points): Line => ({ points, closed: true, look: "draft" })),
    ...(d?.within.length ? [{ points: d.within.map((p) => new Vector3(...p)), closed: true, look: "region" as const }] : []),
    ...(drawing.value.length > 0 ? [{ points: drawing.value, closed: false, look: "draft" as const, knots: corner.current.length > 0 }] : []),
    ...(trimline.value.length ? [{ points: trimDrawn, closed: false, look: "trimline" as const }, { points: trimline.value, closed: false, look: "knots" as const, knots: true }] : []),
  ];
  const marks: Mark[] = (limb?.reply.places ?? []).map((one) => ({ name: one.name, label: term(one.name), point: new Vector3(...vec3(one.position_mm)), state: d?.at === one.name ? "chosen" : "set" }));

  return (
    <div class="work">
      <Stage
        shown={shown}
        label={t("stage.rectify")}
        mode={mode}
        modes={["surface", "difference", "sure"]}
        level={level}
        marks={marks}
        lines={drawn}
        handle={d ? { point: new Vector3(...d.anchor), normal: new Vector3(...d.normal), depth_mm: sign * d.depth_mm } : null}
        onHandle={onHandle}
        against={before === null ? scanWords(limb?.reply.sock_mm ?? 0, book?.recipe.edits ?? []) : t("against.before", before)}
        tool={d || keeping.value ? null : hands}
        onReady={(made) => (viewer.current = made)}
        keys={d ? t("rectify.keys.open") : t(`rectify.keys.${tool.value}` as TextKey)}
        tools={
          <div class="tools" role="toolbar" aria-label={t("rectify.tools")}>
            {TOOLS.map((one) => (
              <button
                key={one.name}
                type="button"
                class={`tool ${tool.value === one.name ? "on" : ""}`}
                aria-pressed={tool.value === one.name}
                onClick={() => {
                  drop();
                  corner.current = [];
                  tool.value = one.name;
                }}
              >
                <Icon name={one.icon} />
                {t(`tool.${one.name}` as TextKey)}
              </button>
            ))}
          </div>
        }
      >
        {d && (
          <div class="hint-card at-handle" role="status">
            <b class={`big ${sign < 0 ? "neg" : "pos"}`}>{signed(sign * d.depth_mm)} mm</b> <span class="soft">{t(sign < 0 ? "carved" : "built")}</span>
            {girthHere && level.value !== null && (
              <>
                <br />
                <span class="soft">{t("girth.at", level.value.toFixed(0))}</span> <b>{girthHere.now.toFixed(1)}</b> <span class={toneOf(girthHere.change)}>({signed(girthHere.change)})</span>
              </>
            )}
          </div>
        )}
        {asked.refused.value && (
          <div class="stage-note">
            <Refusal refused={asked.refused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("step.rectify")}>
        <h1 class="unseen">{t("step.rectify")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          {d && (
            <section class="edit">
              <div class="row-head">
                <h2>{t(d.kind === "load" ? "load.head" : "relief.head")}</h2>
                <span class="grow" />
                <Segments label={t("load.or.relief")} value={d.kind} options={[{ value: "load", text: t("load") }, { value: "relieve", text: t("relief") }]} onChange={(kind) => change({ kind })} />
              </div>
              <div class="row2">
                <NumberField label={t(d.kind === "load" ? "depth.in" : "depth.out")} unit="mm" step={0.1} decimals={2} min={0.1} max={60} value={d.depth_mm} onChange={(depth_mm) => change({ depth_mm })} />
                <NumberField label={t("soft.edge")} unit="mm" step={1} decimals={1} min={1} max={200} value={d.falloff_mm} onChange={(falloff_mm) => change({ falloff_mm })} />
                {!d.within.length && <NumberField label={t("flat")} unit="mm" step={1} decimals={1} min={0} max={100} value={d.flat_mm} onChange={(flat_mm) => change({ flat_mm })} />}
              </div>
              <div class={`eff ${waits.value ? "waits" : ""}`}>
                {level.value !== null && girthHere && (
                  <span>
                    {t("girth.at", level.value.toFixed(0))} <b class={toneOf(girthHere.change)}>{signed(girthHere.change)} mm</b>
                  </span>
                )}
                {volume !== null && (
                  <span>
                    {t("volume")} <b class={volume < 0 ? "neg" : "pos"}>{signed(volume)} mL</b>
                  </span>
                )}
              </div>
              {line?.concerns.map((one) => <Notice key={said(one.finding)} tone="amber" title={said(one.finding)} />)}
              {unsaid ? (
                <Notice tone="red" title={unsaid.what} action={<Button onClick={() => change({ accept: [...d.accept, ...unsaid.words] })}>{t("is.meant")}</Button>}>
                  <p>{t("concern.do")}</p>
                </Notice>
              ) : (
                <Refusal refused={refused.value} />
              )}
              {asksDepth.value && (
                <Notice tone="amber" title={t("deep", d.depth_mm.toFixed(1))} action={<Button onClick={() => (asksDepth.value = false)}>{t("is.meant")}</Button>} />
              )}
              <div class="acts">
                <Button go class="grow" off={keeping.value ? t("loading") : refused.value ? t("refused.first") : null} onClick={keep}>
                  {t("keep.edit")}
                </Button>
                <Button onClick={drop}>{t("drop.edit")}</Button>
              </div>
            </section>
          )}
          {!d && trimline.value.length > 0 && (
            <section class="edit">
              <h2>{t("tool.trimline")}</h2>
              <p class="soft small-note">{t("trimline.points", trimline.value.length)}</p>
              <div class="acts">
                <Button go class="grow" off={keeping.value ? t("loading") : trimline.value.length < LEAST_TRIM && t("trimline.few")} onClick={() => void add({ kind: "trimline", parameters: { through: alongTrimline().map((p) => [p.x, p.y, p.z]), keep: "distal", positions_in: "mesh" }, accept: [] })}>
                  {t("trimline.cut")}
                </Button>
                <Button onClick={drop}>{t("drop.edit")}</Button>
              </div>
            </section>
          )}
          {!d && (tool.value === "region" || tool.value === "brush" || tool.value === "place") && trimline.value.length === 0 && (
            <section class="small-note by-drawing">
              <p class="soft">{t(`rectify.how.${tool.value}` as TextKey)}</p>
              <div class="row2">
                <NumberField label={t(tool.value === "brush" ? "brush.size" : "soft.edge")} unit="mm" step={1} decimals={0} min={4} max={60} value={size.value} onChange={(value) => (size.value = value)} />
                {tool.value === "brush" && <NumberField label={t("soft.edge")} unit="mm" step={1} decimals={0} min={1} max={60} value={soft.value} onChange={(value) => (soft.value = value)} />}
                {tool.value === "place" && (limb?.reply.places.length ?? 0) > 0 && (
                  <label class="number">
                    <span class="label-line">{t("at.place")}</span>
                    <span class="field">
                      <select
                        value=""
                        onChange={(event) => {
                          const one = limb?.reply.places.find((p) => p.name === event.currentTarget.value);
                          const v = viewer.current;
                          if (!one || !base || !v?.surface) return;
                          const seed = nearest(base, vec3(one.position_mm));
                          const n = v.surface.normals;
                          open({ kind: "load", depth_mm: 2, falloff_mm: size.value, flat_mm: 0, at: one.name, within: [], anchor: vec3(one.position_mm), normal: [n[3 * seed], n[3 * seed + 1], n[3 * seed + 2]], seed, accept: [] });
                        }}
                      >
                        <option value="">{t("choose")}</option>
                        {limb?.reply.places.map((one) => (
                          <option key={one.name} value={one.name}>
                            {term(one.name)}
                          </option>
                        ))}
                      </select>
                    </span>
                  </label>
                )}
              </div>
            </section>
          )}
          {(tool.value === "levels" || tool.value === "other") && <OtherEdit key={tool.value} first={tool.value === "levels" ? "reduction" : (first ?? "sock")} only={tool.value === "levels" ? "levels" : null} places={limb?.reply.places.map((one) => one.name) ?? []} busy={keeping.value} waits={waits.value} volume_ml={trial.value && line ? changed(line.volume) : null} refused={refused.value} onTry={tryNew} onKeep={add} onDrop={drop} />}
          {tool.value === "template" && (
            <TemplateEdits
              room={room}
              tried={trial.value !== null}
              waits={waits.value}
              refused={refused.value}
              busy={keeping.value}
              onTry={(body) => tryNew({ ...body, parameters: { ...body.parameters } })}
              onKeep={(body) => void add({ ...body, parameters: { ...body.parameters } })}
              onDrop={drop}
            />
          )}
          <Refusal refused={act.refused.value ?? ledgered.refused.value} />
          {book && <RecipeList book={book} listed={listed} chosen={chosenRow.value} onChoose={(n) => (chosenRow.value = n)} onUndo={() => void undo()} onRedo={() => void redo()} onChange={(number, body) => void changeEdit(number, body)} onRemove={(number) => {
              chosenRow.value = null; // the next edit has its number now
              void removeEdit(number);
            }} />}
          {book && book.recipe.edits.length > 1 && (
            <section>
              <label class="stacked">
                <span>{t("against.which")}</span>
                <span class="field">
                  <select
                    value={before ?? ""}
                    onChange={(event) => {
                      againstEdit.value = event.currentTarget.value ? Number(event.currentTarget.value) : null;
                      mode.value = "difference";
                    }}
                  >
                    <option value="">{t("compare.scan")}</option>
                    {book.recipe.edits.slice(1).map((one) => (
                      <option key={one.number} value={one.number}>
                        {t("compare.before.edit", one.number, wordsOf(one).title)}
                      </option>
                    ))}
                  </select>
                </span>
              </label>
            </section>
          )}
          {book?.refusal && <Refusal refused={new Refused("", said(book.refusal), 422, book.refusal as Finding)} />}
          {book?.ledger && book.ledger.lines.length > 0 && <LedgerTable ledger={book.ledger} line={line} level={level.value} onLevel={(h) => (level.value = h)} />}
        </div>
        <div class="next">
          <Button go={!open_ && !["template", "levels", "other"].includes(tool.value)} big off={d ? t("rectify.open") : open_ ? t("trimline.open") : null} trailing={open_ ? undefined : "next"} onClick={() => go(href.step(room.id, "send"))}>
            {d ? t("rectify.open") : open_ ? t("trimline.open") : t("rectify.next")}
          </Button>
        </div>
      </aside>
    </div>
  );
}

/** Less, more, or nothing that a decimal shows. */
const toneOf = (change: number): string => (change < -0.05 ? "neg" : change > 0.05 ? "pos" : "");

/** A ring round a place of the surface, in the plane that touches it there. */
function ringOn(hit: Hit, radius_mm: number): Vector3[] {
  const along = new Vector3(0, 0, 1).cross(hit.normal);
  if (along.lengthSq() < 1e-6) along.set(1, 0, 0);
  along.normalize();
  const across = hit.normal.clone().cross(along);
  return Array.from({ length: 36 }, (_, i) => {
    const angle = (Math.PI * i) / 18;
    return hit.point.clone().addScaledVector(along, radius_mm * Math.cos(angle)).addScaledVector(across, radius_mm * Math.sin(angle)).addScaledVector(hit.normal, 0.3);
  });
}

/** A line without points that lie on their neighbour; a hand closes a line where it began. */
function apart(line: readonly Vec3[]): Vec3[] {
  const kept: Vec3[] = [];
  for (const p of line) if (!kept.length || distance(kept[kept.length - 1], p) > APART_MM) kept.push(p);
  while (kept.length > 1 && distance(kept[0], kept[kept.length - 1]) <= APART_MM) kept.pop();
  return kept;
}

function widest(values: Float32Array): number {
  let most = 0;
  for (const v of values) if (Math.abs(v) > most) most = Math.abs(v);
  return widthFor(most);
}

function nearest(data: SurfaceData, p: Vec3): number {
  let best = 0;
  let least = Infinity;
  for (let i = 0; i < data.positions.length; i += 3) {
    const gap = (data.positions[i] - p[0]) ** 2 + (data.positions[i + 1] - p[1]) ** 2 + (data.positions[i + 2] - p[2]) ** 2;
    if (gap < least) [best, least] = [i / 3, gap];
  }
  return best;
}

/** Sum of share times area over the vertices moved, mm2: times depth it is the volume of the edit. */
function areasOf(data: SurfaceData, { vertices, shares }: Shares): number {
  const share = new Map<number, number>();
  vertices.forEach((v, i) => share.set(v, shares[i]));
  let sum = 0;
  const at = data.positions;
  for (let f = 0; f < data.indices.length; f += 3) {
    const [a, b, c] = [data.indices[f], data.indices[f + 1], data.indices[f + 2]];
    const part = (share.get(a) ?? 0) + (share.get(b) ?? 0) + (share.get(c) ?? 0);
    if (!part) continue;
    const u = [0, 1, 2].map((k) => at[3 * b + k] - at[3 * a + k]);
    const v = [0, 1, 2].map((k) => at[3 * c + k] - at[3 * a + k]);
    sum += (part / 6) * Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  return sum;
}

function RecipeList({ book, listed, chosen, onChoose, onUndo, onRedo, onChange, onRemove }: { book: Ledgered; listed: readonly ShownEdit[] | null; chosen: number | null; onChoose: (number: number | null) => void; onUndo: () => void; onRedo: () => void; onChange: (number: number, body: Schemas["EditChange"]) => void; onRemove: (number: number) => void }) {
  const lines = book.ledger?.lines ?? [];
  const { can_undo, can_redo, fits, notes } = book.recipe;
  /** What was undone is not known before the answer: until then no number means an edit. */
  const unknown = listed === null;
  const edits = listed ?? book.recipe.edits.map((one): ShownEdit => ({ ...one, was: null }));
  return (
    <section class="recipe">
      <div class="row-head">
        <h2>{t("recipe")}</h2>
        <span class="grow" />
        <span class="small faint ml">mL</span>
        <Button bare icon="undo" class="icon-only" label={t("undo")} off={can_undo ? null : t("nothing.undo")} onClick={onUndo} />
        <Button bare icon="redo" class="icon-only" label={t("redo")} off={can_redo ? null : t("nothing.redo")} onClick={onRedo} />
      </div>
      {!fits && !book.refusal && (
        <Notice tone="amber" title={t("recipe.fits.not")}>
          {t("recipe.fits.not.do")}
        </Notice>
      )}
      {edits.length === 0 && <p class="soft small-note">{t("recipe.empty")}</p>}
      <ol class={`edits ${unknown ? "waits" : ""}`} aria-busy={unknown || undefined} inert={unknown}>
        {edits.map((one) => {
          const words = wordsOf(one);
          const line = lines.find((l) => l.number === one.was);
          const change = line && one.on ? changed(line.volume) : null;
          return (
            <li
              key={one.number}
              class={`ed ${one.on ? "" : "offd"} ${chosen === one.number ? "on" : ""}`}
              draggable
              onDragStart={(event) => event.dataTransfer?.setData("text/plain", String(one.number))}
              onDragOver={(event) => event.preventDefault()}
              onDrop={(event) => {
                event.preventDefault();
                const from = Number(event.dataTransfer?.getData("text/plain"));
                if (from && from !== one.number) onChange(from, { number: one.number });
              }}
            >
              <button
                type="button"
                class="grip"
                aria-label={t("recipe.move", one.number)}
                onKeyDown={(event) => {
                  const by = event.key === "ArrowUp" ? -1 : event.key === "ArrowDown" ? 1 : 0;
                  const to = one.number + by;
                  if (!by || to < 1 || to > edits.length) return;
                  event.preventDefault();
                  onChange(one.number, { number: to });
                }}
              >
                <Icon name="grip" small />
              </button>
              <Switch on={one.on} label={`${one.number} ${words.title}`} onChange={(on) => onChange(one.number, { on })} />
              <button type="button" class="ed-name" aria-expanded={chosen === one.number} onClick={() => onChoose(chosen === one.number ? null : one.number)}>
                {one.number}&ensp;{words.title}
                <em>{words.where}</em>
              </button>
              <span class="num">{words.amount}</span>
              <span class={`num ${change === null ? "" : change < -0.05 ? "neg" : change > 0.05 ? "pos" : ""}`}>{!one.on ? t("off").toLowerCase() : change !== null ? signed(change) : one.was === null ? "…" : ""}</span>
              {line && line.told.length > 0 && chosen !== one.number && (
                <p class="ed-more small soft">{line.told.map(said).join(" ")}</p>
              )}
              {chosen === one.number && (
                <div class="ed-more">
                  {words.field && <NumberField label={t("depth")} unit="mm" step={0.1} decimals={2} min={0.1} max={60} value={Number((one.parameters as Record<string, unknown>).depth_mm)} onChange={(depth_mm) => onChange(one.number, { parameters: { ...(one.parameters as Record<string, never>), depth_mm } as never })} />}
                  <p class="small faint">{one.text}</p>
                  {line?.told.map((one) => (
                    <p key={said(one)} class="small faint">
                      {said(one)}
                    </p>
                  ))}
                  <Button onClick={() => onRemove(one.number)}>{t("recipe.remove")}</Button>
                </div>
              )}
            </li>
          );
        })}
      </ol>
      {notes.map((one) => (
        <p key={said(one)} class="small soft">
          {said(one)}
        </p>
      ))}
    </section>
  );
}

function LedgerTable({ ledger, line, level, onLevel }: { ledger: NonNullable<Ledgered["ledger"]>; line: Schemas["LineReply"] | null; level: number | null; onLevel: (height_mm: number) => void }) {
  const first = ledger.lines[0];
  const last = ledger.lines[ledger.lines.length - 1];
  const now = line?.after ?? last.after;
  const before = line?.before ?? last.before;
  const all = changed(ledger.volume);
  const span = ledger.volume;
  const most = ledger.lines.flatMap((one) => (one.extreme ? [{ number: one.number, ...one.extreme }] : []));
  return (
    <section class="ledger">
      <div class="row-head">
        <h2>{t("ledger")}</h2>
        <span class="grow" />
        <span class="small soft">
          {t("ledger.all")} <b>{all === null ? "–" : `${signed(all)} mL`}</b>
          {all !== null && span && span.before_ml > 0 && `, ${signed((100 * all) / span.before_ml)} %`}
        </span>
      </div>
      <table class="led">
        <thead>
          <tr>
            <th class="num">{t("th.height")}</th>
            <th class="num">{t("th.scan")}</th>
            <th class="num">{t("th.now")}</th>
            <th class="num">{t("th.change")}</th>
            <th class="num">{t("th.this")}</th>
          </tr>
        </thead>
        <tbody>
          {[...ledger.levels_mm.keys()].reverse().map((i) => {
            const h = ledger.levels_mm[i];
            const [scan, here, was] = [first.before.girths_mm[i], now.girths_mm[i], before.girths_mm[i]];
            const change = scan !== null && here !== null ? here - scan : null;
            const mine = was !== null && here !== null ? here - was : null;
            return (
              <tr key={h} class={`pick ${level !== null && Math.abs(level - h) < 8 ? "on" : ""}`} tabIndex={0} onClick={() => onLevel(h)} onFocus={() => onLevel(h)}>
                <td class="num">{h.toFixed(0)}</td>
                <td class="num soft">{scan?.toFixed(1) ?? "–"}</td>
                <td class="num">{here?.toFixed(1) ?? "–"}</td>
                <td class={`num ${(change ?? 0) < -0.05 ? "neg" : (change ?? 0) > 0.05 ? "pos" : ""}`}>{change === null ? "–" : signed(change)}</td>
                <td class="num soft">{mine === null ? "–" : signed(mine)}</td>
              </tr>
            );
          })}
        </tbody>
        {most.length > 0 && (
          <tbody>
            <tr>
              <th colSpan={5} scope="colgroup">
                {t("ledger.most")}
              </th>
            </tr>
            {most.map((one) => (
              <tr key={one.number} class="pick" tabIndex={0} onClick={() => onLevel(one.height_mm)} onFocus={() => onLevel(one.height_mm)}>
                <td class="num">{one.height_mm.toFixed(0)}</td>
                <td class="num soft">{one.before_mm?.toFixed(1) ?? "–"}</td>
                <td class="num">{one.after_mm?.toFixed(1) ?? "–"}</td>
                <td class="num soft">{one.number}.</td>
                <td class="num">{one.before_mm === null || one.after_mm === null ? "–" : signed(one.after_mm - one.before_mm)}</td>
              </tr>
            ))}
          </tbody>
        )}
      </table>
      {span && (span.low_mm !== null || span.high_mm !== null) && <p class="small faint">{t("ledger.span", span.low_mm?.toFixed(0) ?? "0", span.high_mm?.toFixed(0) ?? "–")}</p>}
    </section>
  );
}

/** By how much an edit changed the volume; null where it is not comparable. */
function changed(volume: Schemas["VolumeChange"] | null | undefined): number | null {
  return volume ? volume.after_ml - volume.before_ml : null;
}
