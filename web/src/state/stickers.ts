/** Which place a numbered sticker marks, as this clinic used it last; kept by this browser. */

const KEPT = "limbgram.stickers";

function known(): Record<string, string> {
  const kept = localStorage.getItem(KEPT);
  return kept ? (JSON.parse(kept) as Record<string, string>) : {};
}

/** The place that the sticker marked last; empty where it never marked one. */
export const nameOfSticker = (number: number): string => known()[String(number)] ?? "";

export function rememberSticker(number: number, name: string): void {
  localStorage.setItem(KEPT, JSON.stringify({ ...known(), [String(number)]: name }));
}
