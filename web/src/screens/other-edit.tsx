/** Any edit by its parameters: for those that are not drawn on the limb. What each means stands beside it. */
import { useSignal } from "@preact/signals";

import { type Schemas, api, taken } from "../api/client";
import { Button } from "../design/parts";
import { Refusal } from "../design/refusal";
import { useAsked } from "../state/asked";
import { expert } from "../state/settings";
import { t, tOr } from "../texts";

const FIRST_LEVEL = ["sock", "smoothing", "offset", "extension", "flare", "distal-end", "plane-cut", "fill", "wall", "clean"];

export function OtherEdit({ first, only, places, busy, onKeep }: { first: string; only: readonly string[] | null; places: readonly string[]; busy: boolean; onKeep: (body: { kind: string; parameters: Record<string, unknown>; accept: string[] }) => void }) {
  const kinds = useAsked(() => taken(api.GET("/api/v1/edits", {})), []);
  const kind = useSignal(first);
  const given = useSignal<Record<string, string>>({});
  const all = (kinds.value.value ?? []).filter((one) => one.kind !== "from-template" && ((only ? only.includes(one.kind) : expert.value || FIRST_LEVEL.includes(one.kind))));
  const one = all.find((k) => k.kind === kind.value) ?? all[0];
  const parameters = (one?.parameters ?? []).filter((p) => p.name !== "positions_in");
  const lacks = parameters.filter((p) => !/else/.test(p.expected) && !(given.value[p.name] ?? "").trim());
  const keep = () => {
    if (!one) return;
    const made: Record<string, unknown> = {};
    for (const p of parameters) {
      const text = (given.value[p.name] ?? "").trim();
      if (text) made[p.name] = valueOf(text, p);
    }
    onKeep({ kind: one.kind, parameters: made, accept: [] });
  };
  return (
    <section class="edit other-edit">
      <h2>{t(only ? "tool.levels" : "tool.other")}</h2>
      <Refusal refused={kinds.refused.value} />
      <span class="field">
        <select
          aria-label={t("tool.other")}
          value={one?.kind ?? ""}
          onChange={(event) => {
            kind.value = event.currentTarget.value;
            given.value = {};
          }}
        >
          {all.map((k) => (
            <option key={k.kind} value={k.kind}>
              {tOr(`edit.${k.kind}`, k.kind)}
            </option>
          ))}
        </select>
      </span>
      {one && <p class="soft small-note">{one.does}</p>}
      {parameters.map((p) => (
        <label key={p.name} class="stacked">
          <span>{p.name.replace(/_mm$/, "").replaceAll("_", " ")}</span>
          <span class="field">
            <input list={/Place/.test(p.expected) ? "places-known" : undefined} placeholder={placeholder(p)} value={given.value[p.name] ?? ""} onInput={(event) => (given.value = { ...given.value, [p.name]: event.currentTarget.value })} onKeyDown={(event) => event.key === "Enter" && !lacks.length && keep()} />
            {p.name.endsWith("_mm") && <span class="u">mm</span>}
          </span>
          <span class="small faint">{p.meaning}</span>
        </label>
      ))}
      <datalist id="places-known">
        {places.map((name) => (
          <option key={name} value={name} />
        ))}
      </datalist>
      <div class="acts">
        <Button go class="grow" off={busy ? t("loading") : lacks.length ? t("other.lacks", lacks.map((p) => p.name).join(", ")) : null} onClick={keep}>
          {t("keep.edit")}
        </Button>
      </div>
    </section>
  );
}

const placeholder = (p: Schemas["Parameter"]) => {
  const otherwise = /else (.*)$/.exec(p.expected)?.[1];
  if (otherwise && otherwise !== "None") return otherwise.replaceAll("'", "");
  return /tuple|list/.test(p.expected) ? "20, 200" : "";
};

/** What was typed as the server wants it: a number, a list of numbers, yes or no, or a word. */
export function valueOf(text: string, p: { readonly expected: string }): unknown {
  if (/bool/.test(p.expected)) return /^(true|yes|ja|1)$/i.test(text);
  const parts = text.split(/[,;]\s*|\s+/).filter(Boolean).map((part) => part.replace("−", "-"));
  const numbers = parts.map(Number);
  if (/tuple|list|Sequence/.test(p.expected)) return numbers.every(Number.isFinite) ? numbers : parts;
  const one = Number(text.replace(",", ".").replace("−", "-"));
  return Number.isFinite(one) ? one : text;
}
