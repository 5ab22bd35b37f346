/** Numbers as people read and type them: the decimal mark of the language chosen, a true minus, and a ± that is never nothing. */
import { language } from "./texts";

/** A number with so many decimals; a dash where there is none. */
export function fixed(value: number | null | undefined, decimals: number): string {
  return value === null || value === undefined || !Number.isFinite(value) ? "–" : marked(value.toFixed(decimals));
}

/** The same with a true minus, and a plus where the sign tells. */
export function signed(value: number, decimals = 1): string {
  const size = Math.abs(value).toFixed(decimals);
  if (Number(size) === 0) return marked(size);
  return (value < 0 ? "−" : "+") + marked(size);
}

/** What stands behind a ±. */
export const within = (value: number | null | undefined, decimals: number): string => fixed(value, decimalsOf(value ?? 0, decimals));

/** One digit at least: what is smaller than the decimals is not told as nothing. */
export const decimalsOf = (value: number, decimals: number): number =>
  value > 0 && value < 0.5 * 10 ** -decimals ? Math.min(-Math.floor(Math.log10(value)), 9) : decimals;

/** A number as it stands in a field: with as many decimals as it has. */
export const typedAs = (value: number): string => marked(String(value));

/** The number that somebody typed, with a comma or a point; null: it is none. */
export function numberIn(text: string): number | null {
  const plain = text.trim().replace(",", ".").replace("−", "-");
  return /^[+-]?(\d+\.?\d*|\.\d+)$/.test(plain) ? Number(plain) : null;
}

/** A size in memory or on disk. */
export function bytes(count: number): string {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let [size, unit] = [count, 0];
  while (size >= 1000 && unit < units.length - 1) [size, unit] = [size / 1000, unit + 1];
  return `${fixed(size, size < 10 && unit > 1 ? 1 : 0)} ${units[unit]}`;
}

/** A time in seconds, minutes or hours. */
export function duration(seconds: number): string {
  const s = Math.max(0, Math.round(seconds));
  if (s < 90) return `${s} s`;
  const m = Math.round(s / 60);
  return m < 90 ? `${m} min` : `${Math.floor(m / 60)} h ${m % 60} min`;
}

/** Digits with a decimal point and commas between thousands, with the marks of the language chosen. */
export function marked(digits: string): string {
  return language.value === "en" ? digits : digits.replace(/[.,]/g, (mark) => (mark === "." ? "," : "."));
}
