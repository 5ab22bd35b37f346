/**
 * The dial: where the photos were taken from, seen from above, and where some are missing.
 *
 * Outer ring: photos taken low. Inner ring: photos taken from higher up. One stands at photo 1, below.
 */
import { t } from "../texts";

export interface DialPhoto {
  readonly name: string;
  /** Round the limb, in degrees, counter-clockwise seen from above, from photo 1. */
  readonly azimuth_deg: number;
  readonly elevation_deg: number;
}

export interface DialData {
  readonly photos: readonly DialPhoto[];
  /** Gaps: sectors without photos, in the same degrees. */
  readonly gaps: readonly { readonly from_deg: number; readonly to_deg: number; readonly high: boolean }[];
  readonly add: readonly { readonly letter: string; readonly azimuth_deg: number; readonly high: boolean }[];
}

/** Of each ring. */
const SECTORS = 24;
/** Degrees above the horizon from which a photo counts as taken high. */
export const HIGH_DEG = 35;
const SPREAD_DEG = 21;

/** Photo 1 lies at the bottom; degrees go counter-clockwise, so the first quarter lies on the right. */
export function onDial(azimuth_deg: number, radius: number): readonly [number, number] {
  const a = (azimuth_deg * Math.PI) / 180;
  return [radius * Math.sin(a), radius * Math.cos(a)];
}

function sector(from: number, to: number, inner: number, outer: number): string {
  const p = (a: number, r: number) =>
    onDial(a, r)
      .map((v) => v.toFixed(1))
      .join(" ");
  return `M${p(from, outer)}A${outer} ${outer} 0 0 0 ${p(to, outer)}L${p(to, inner)}A${inner} ${inner} 0 0 1 ${p(from, inner)}Z`;
}

const apart = (a: number, b: number) => Math.abs(((((a - b) % 360) + 540) % 360) - 180);

export function Dial({ data, label }: { data: DialData | null; label: string }) {
  const rings = [
    { high: false, inner: 92, outer: 118, at: 105 },
    { high: true, inner: 62, outer: 88, at: 75 },
  ];
  const photos = data?.photos ?? [];
  return (
    <svg class="dial" viewBox="-190 -146 380 292" role="img" aria-label={label}>
      {rings.map(({ high, inner, outer, at }) => {
        const mine = photos.filter((one) => one.elevation_deg >= HIGH_DEG === high);
        const wide = 360 / SECTORS;
        const used = mine.length > 0 || (data?.gaps.some((gap) => gap.high === high) ?? false);
        return (
          <g key={String(high)} class={used ? "" : "unused"}>
            {Array.from({ length: SECTORS }, (_, i) => {
              const middle = i * wide;
              const nearest = Math.min(360, ...mine.map((one) => apart(one.azimuth_deg, middle)));
              const missing = data?.gaps.some((gap) => gap.high === high && within(middle, gap.from_deg, gap.to_deg)) ?? false;
              const look = missing ? "missing" : nearest <= SPREAD_DEG / 1.4 ? "full" : nearest <= SPREAD_DEG * 1.3 ? "half" : "none";
              return <path key={i} class={look} d={sector(middle - wide / 2 + 0.7, middle + wide / 2 - 0.7, inner, outer)} />;
            })}
            {mine.map((one) => {
              const [cx, cy] = onDial(one.azimuth_deg, at);
              return (
                <circle key={one.name} class="photo" cx={cx.toFixed(1)} cy={cy.toFixed(1)} r="4">
                  <title>{one.name}</title>
                </circle>
              );
            })}
            {(data?.add ?? [])
              .filter((one) => one.high === high)
              .map((one) => {
                const [x, y] = onDial(one.azimuth_deg, at);
                return (
                  <g key={one.letter} class="add">
                    <circle cx={x.toFixed(1)} cy={y.toFixed(1)} r="10" />
                    <text x={x.toFixed(1)} y={(y + 4).toFixed(1)}>
                      {one.letter}
                    </text>
                  </g>
                );
              })}
          </g>
        );
      })}
      <path class="limb-shape" d="M0-31c17 0 28 9 29 25 1 14-4 32-17 36-7 2-17 2-24 0-13-4-18-22-17-36 1-16 12-25 29-25z" />
      <text class="way" x="0" y="-126">
        {t("dial.back")}
      </text>
      <text class="way" x="0" y="136">
        {t("dial.front")}
      </text>
      <text class="way left" x="-126" y="4">
        {t("dial.left")}
      </text>
      <text class="way right" x="126" y="4">
        {t("dial.right")}
      </text>
    </svg>
  );
}

function within(a: number, from: number, to: number): boolean {
  const turn = (v: number) => ((v % 360) + 360) % 360;
  return turn(a - from) <= turn(to - from);
}
