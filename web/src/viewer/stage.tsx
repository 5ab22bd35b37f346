/**
 * The stage as a part of a screen: the canvas with its overlay, modes, legend, view cube and Fit.
 *
 * The canvas is made once and told what changed; it is not a scene in a component tree.
 */
import { type Signal, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";

import { Icon } from "../design/icons";
import { Button, Segments } from "../design/parts";
import type { AxesTurn } from "../geometry/axes-turn";
import { DIFFERENCE_COLOURS, DIFFERENCE_LIMITS_MM, SURE_STOPS_MM } from "../geometry/scales";
import { cut, heightsOf } from "../geometry/section";
import type { Rigid } from "../geometry/vectors";
import { fixed } from "../numbers";
import { language, t } from "../texts";
import type { Handle } from "./handles";
import { type Line, type Mark, Overlay, type Words } from "./overlay";
import type { Hit, Mode, Surface, SurfaceData } from "./surface";
import { type Tool, Viewer } from "./viewer";

export interface Shown {
  readonly surface: SurfaceData;
  /** Into the frame shown: aligned, or a guess. */
  readonly frame: Rigid;
  readonly aligned: boolean;
  /** Signed distances in mm to what the surface is compared with. */
  readonly difference?: { readonly values: Float32Array; readonly wider: number } | null;
}

interface StageProps {
  readonly shown: Shown | null;
  readonly label: string;
  readonly mode: Signal<Mode>;
  readonly modes: readonly Mode[];
  readonly level?: Signal<number | null>;
  readonly onLevel?: (height_mm: number) => void;
  readonly marks?: readonly Mark[];
  readonly lines?: readonly Line[];
  readonly handle?: Handle | null;
  readonly onHandle?: (depth_mm: number, done: boolean, fine: boolean) => void;
  /** The long axis is drawn with handles, and this is told what a hand does to them. */
  readonly onAxes?: (by: AxesTurn, done: boolean) => void;
  readonly tool?: Tool | null;
  readonly onClick?: (hit: Hit | null) => void;
  readonly onReady?: (viewer: Viewer | null) => void;
  readonly keys: string;
  readonly tools?: ComponentChildren;
  readonly against?: string;
  /** What the two signs of a difference are called; else taken away and added. */
  readonly ends?: readonly [string, string];
  /** What is drawn in grey stripes, where some of it is. */
  readonly hatched?: string;
  readonly children?: ComponentChildren;
}

export function words(): Words {
  return {
    mm: "mm",
    level: t("level"),
    faces: {
      front: t("face.front"),
      back: t("face.back"),
      left: t("side.L"),
      right: t("side.R"),
      above: "",
      below: "",
    },
    edges: {
      front: [t("way.anterior"), t("way.front")],
      back: [t("way.posterior"), t("way.back")],
      left: [t("side.L"), t("way.left")],
      right: [t("side.R"), t("way.right")],
      above: ["", t("way.above")],
      below: ["", t("way.below")],
    },
  };
}

/** A phone's canvas is looked at; what is placed or drawn by hand needs a larger one. */
const narrow = matchMedia("(max-width: 640px)");

export function Stage(props: StageProps) {
  const holder = useRef<HTMLElement>(null);
  const viewer = useRef<Viewer | null>(null);
  const overlay = useRef<Overlay | null>(null);
  const broken = useSignal(false);
  const parallel = useSignal(false);
  const { shown } = props;

  useEffect(() => {
    if (!holder.current) return;
    let made: Viewer;
    try {
      made = new Viewer(holder.current);
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      broken.value = true;
      return;
    }
    viewer.current = made;
    const over = new Overlay(made, words());
    overlay.current = over;
    made.onFrame = () => over.update();
    over.onView = (view) => void made.look(view);
    made.onParallel = (on) => (parallel.value = on);
    props.onReady?.(made);
    return () => {
      props.onReady?.(null);
      over.remove();
      made.dispose();
      viewer.current = null;
    };
  }, []);

  const before = useRef<Shown | null>(null);
  useEffect(() => {
    const v = viewer.current;
    if (!v || !shown) return;
    const first = before.current === null || before.current.surface.positions.length === 0;
    if (before.current?.surface !== shown.surface) v.show(shown.surface, shown.frame, !first);
    else v.surface?.place(shown.frame);
    if (before.current?.aligned !== shown.aligned && !first) void v.look(null);
    before.current = shown;
    v.surface?.colourBy(props.mode.value);
    v.draw();
  }, [shown]);

  useEffect(() => {
    if (shown?.difference) viewer.current?.surface?.showDifference(shown.difference.values, shown.difference.wider);
    viewer.current?.draw();
  }, [shown?.difference, shown?.surface]);

  const mode = props.mode.value;
  useEffect(() => viewer.current?.colourBy(mode), [mode, shown]);

  const heights = useMemo(() => (shown ? heightsOf(shown.surface.positions, shown.frame) : null), [shown]);
  const span = useMemo(() => {
    if (!heights?.length) return null;
    let [low, high] = [Infinity, -Infinity];
    for (const h of heights) [low, high] = [Math.min(low, h), Math.max(high, h)];
    return [Math.max(0, Math.ceil(low)), Math.floor(high)] as const;
  }, [heights]);
  const level = props.level?.value ?? null;
  const section = useMemo(
    () => (shown && heights && level !== null ? cut(shown.surface.positions, shown.surface.indices, heights, level, shown.frame) : null),
    [shown, heights, level],
  );

  useEffect(() => {
    const o = overlay.current;
    if (!o) return;
    o.words = words();
    o.section = section;
    o.span = props.level ? span : null;
    o.marks = props.marks ?? [];
    o.lines = props.lines ?? [];
    o.handle = narrow.matches ? null : (props.handle ?? null);
    o.aligned = shown?.aligned ?? false;
    o.onLevel = (h) => {
      if (props.level) props.level.value = h;
      props.onLevel?.(h);
    };
    o.onHandle = props.onHandle ?? null;
    o.axes = props.onAxes !== undefined && !narrow.matches;
    o.onAxes = props.onAxes ?? null;
    if (viewer.current) {
      viewer.current.canvas.setAttribute("aria-label", props.label);
      viewer.current.tool = narrow.matches ? null : (props.tool ?? null);
      viewer.current.onClick = props.onClick ?? null;
      viewer.current.draw();
    }
  });

  return (
    <main
      ref={holder}
      id="content"
      class={`stage ${props.tool && !narrow.matches ? "armed" : ""} ${props.tools && !narrow.matches ? "with-tools" : ""}`}
      aria-label={props.label}
      data-language={language.value}
    >
      {broken.value && (
        <div class="empty">
          <Icon name="warn" />
          <h2>{t("stage.no3d")}</h2>
          <p>{t("stage.no3d.do")}</p>
        </div>
      )}
      {props.tools}
      {shown && props.modes.length > 1 && (
        <div class="modes">
          <Segments
            label={t("modes")}
            value={mode}
            onChange={(next) => (props.mode.value = next)}
            options={props.modes.map((one) => ({
              value: one,
              text: t(`mode.${one}`),
              off: one === "photo" && !shown.surface.colours ? t("mode.photo.none") : one === "sure" && !shown.surface.sigma ? t("mode.sure.none") : undefined,
            }))}
          />
        </div>
      )}
      {shown && (
        <div class="right-tools">
          <Button icon="fit" onClick={() => viewer.current?.fit()}>
            {t("fit")}
          </Button>
          <Button pressed={parallel.value} onClick={() => viewer.current?.setParallel(!parallel.value)}>
            {t("parallel")}
          </Button>
        </div>
      )}
      {shown && mode === "sure" && <SureLegend />}
      {shown && mode === "difference" && (
        <DifferenceLegend
          wider={shown.difference?.wider ?? 1}
          against={props.against ?? t("against.scan")}
          ends={props.ends ?? [t("taken"), t("added")]}
          hatched={props.hatched}
        />
      )}
      {(props.tool || props.tools) && narrow.matches && <p class="phone-only">{t("stage.phone")}</p>}
      {props.children}
      <p class="keys" title={props.keys}>
        {props.keys}
      </p>
    </main>
  );
}

export type { Hit, Surface };

function SureLegend() {
  return (
    <div class="legend">
      <b>{t("sure.title")}</b>
      <div>{t("sure.what")}</div>
      <div class="bar sure" />
      <div class="scale">
        {SURE_STOPS_MM.map((mm, i) => (
          <span key={mm} class={`at-${i}`}>
            {mm ? fixed(mm, 2).slice(1) : "0"}
          </span>
        ))}
      </div>
    </div>
  );
}

function DifferenceLegend({ wider, against, ends, hatched }: { wider: number; against: string; ends: readonly [string, string]; hatched?: string }) {
  /** The first and the last limit on both sides; more would stand on each other. */
  const [near, , , far] = DIFFERENCE_LIMITS_MM;
  const ticks = [
    [1, -far],
    [4, -near],
    [5, near],
    [8, far],
  ] as const;
  const text = (mm: number) => (mm === 0.25 ? "¼" : mm === 0.5 ? "½" : fixed(mm, Number.isInteger(mm) ? 0 : 1));
  return (
    <div class="legend wide">
      <b>{against}</b>
      <div class="ends">
        <span class="neg">{ends[0]}</span>
        <span>mm</span>
        <span class="pos">{ends[1]}</span>
      </div>
      <div class="bar">
        {DIFFERENCE_COLOURS.map((colour) => (
          <i key={colour} style={{ background: colour }} />
        ))}
      </div>
      <div class="scale">
        {ticks.map(([at, mm]) => (
          <span key={mm} style={{ left: `${(at / 9) * 100}%` }}>
            {(mm < 0 ? "−" : "+") + text(Math.abs(mm) * wider)}
          </span>
        ))}
      </div>
      {hatched && (
        <div class="hatched">
          <i />
          {hatched}
        </div>
      )}
    </div>
  );
}
