/** What this browser remembers: the theme and whether the expert's view is on. */
import { signal } from "@preact/signals";

export type Theme = "system" | "light" | "dark";

const read = (key: string) => localStorage.getItem(`limbgram.${key}`);

export const theme = signal<Theme>((read("theme") as Theme | null) ?? "system");
export const expert = signal(read("expert") === "yes");

export function setTheme(next: Theme): void {
  theme.value = next;
  localStorage.setItem("limbgram.theme", next);
  applyTheme();
}

export function setExpert(on: boolean): void {
  expert.value = on;
  localStorage.setItem("limbgram.expert", on ? "yes" : "no");
}

export function applyTheme(): void {
  const root = document.documentElement.classList;
  root.remove("light", "dark");
  if (theme.value !== "system") root.add(theme.value);
}
