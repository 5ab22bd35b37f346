/** Where the user is: the part of the address behind the #. Every place can be opened again. */
import { computed, signal } from "@preact/signals";

export const STEPS = ["capture", "result", "align", "measure", "rectify", "send", "record"] as const;
export type Step = (typeof STEPS)[number];
/** What of a case can be opened: its steps, and comparing, which no step waits for. */
export type Page = Step | "compare";

export type Place =
  | { readonly at: "cases" }
  | { readonly at: "cameras" }
  | { readonly at: "settings" }
  | { readonly at: "phone"; readonly id: string }
  | { readonly at: "case"; readonly id: string; readonly step: Page };

const hash = signal(location.hash);
addEventListener("hashchange", () => {
  hash.value = location.hash;
});

export const place = computed<Place>(() => parse(hash.value));

export function parse(text: string): Place {
  const [first = "", second = "", third = ""] = text.replace(/^#\/?/, "").split("/").map(decodeURIComponent);
  if (first === "cameras" || first === "settings") return { at: first };
  if (first === "phone") return { at: "phone", id: second };
  if (first === "case" && second) return { at: "case", id: second, step: third === "compare" ? third : (STEPS.find((one) => one === third) ?? "capture") };
  return { at: "cases" };
}

export const href = {
  cases: "#/cases",
  cameras: "#/cameras",
  settings: "#/settings",
  step: (id: string, step: Page) => `#/case/${encodeURIComponent(id)}/${step}`,
};

export function go(to: string): void {
  location.hash = to;
}
