/**
 * Any edit by its parameters: for those that are not drawn on the limb. What each means stands beside it.
 *
 * Once something was typed and nothing lacks, the server tries the edit and the limb shows it; it is
 * kept by the button alone.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

import type { Refused } from "../../api/client";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { numberIn, signed } from "../../numbers";
import { expert } from "../../state/settings";
import { type Parameter, editKinds, editName, groupOf, helpOf, labelOf, purposeOf } from "../../edits";
import { t } from "../../texts";
import type { EditBody } from "../rectify/draft";
import { Field } from "./field";
import { FIRST_LEVELS, LevelRows } from "./level-rows";
import { rangeOf, valueOf } from "./values";

/** The edits that have forms of their own. */
const LEARNED = "learned";
const TRY_AFTER_MS = 600;

interface Props {
  readonly first: string;
  /** The group of edits that is offered; null for all that everybody, or an expert, is offered. */
  readonly only: string | null;
  /** The limb's kind, where it was said: edits for other kinds are not offered. */
  readonly limbKind: string | null;
  readonly places: readonly string[];
  readonly busy: boolean;
  readonly waits: boolean;
  /** What the trial does to the volume, mL; null where nothing is tried. */
  readonly volume_ml: number | null;
  readonly refused: Refused | null;
  readonly onTry: (body: EditBody) => void;
  /** Whether it was kept. */
  readonly onKeep: (body: EditBody) => Promise<boolean>;
  readonly onDrop: () => void;
}

export function OtherEdit({ first, only, limbKind, places, busy, waits, volume_ml, refused, onTry, onKeep, onDrop }: Props) {
  const kind = useSignal(first);
  const given = useSignal<Record<string, string>>({});
  const levels = useSignal(FIRST_LEVELS);
  /** Kept as it stands in the fields: a second Enter keeps it no second time. */
  const spent = useSignal(false);
  /** Typed while another edit was being kept. */
  const meanwhile = useRef(false);
  const wait = useRef(0);
  useEffect(() => () => clearTimeout(wait.current), []);
  const fits = (of: readonly (string | null)[]) => !of.length || of.includes(limbKind);
  const asked = (group: string, everyday: boolean) => (only ? group === only : group !== LEARNED && (expert.value || everyday));
  const all = editKinds.value.filter((one) => fits(one.kinds) && asked(one.group, one.everyday));
  const groups = [...new Set(all.map((one) => one.group))];
  const one = all.find((k) => k.kind === kind.value) ?? all[0];
  const parameters = (one?.parameters ?? []).filter((p) => p.name !== "positions_in" && (expert.value || !one?.rarely.includes(p.name)));
  const byLevels = parameters.some((p) => p.name === "heights_mm");
  const fields = parameters.filter((p) => p.name !== "heights_mm" && p.name !== "per_cent");
  const rows = levels.value.filter((row) => row.height.trim() && row.amount.trim());
  const textOf = (p: Parameter) => (given.value[p.name] ?? "").trim();
  const lacks = [
    ...fields.filter((p) => p.needed && !textOf(p)).map((p) => labelOf(one?.kind ?? "", p.name)),
    ...(byLevels && rows.length === 0 ? [t("other.level")] : []),
  ];
  const body = (): EditBody | null => {
    if (!one) return null;
    const made: Record<string, unknown> = {};
    for (const p of fields) {
      const text = textOf(p);
      if (text) made[p.name] = valueOf(text, p);
    }
    if (byLevels) {
      const sorted = rows.map((row) => [numberIn(row.height) ?? NaN, numberIn(row.amount) ?? NaN] as const).sort((a, b) => a[0] - b[0]);
      made["heights_mm"] = sorted.map(([height]) => height);
      made["per_cent"] = sorted.map(([, amount]) => amount);
    }
    return { kind: one.kind, parameters: made, accept: [] };
  };
  const keep = () => {
    clearTimeout(wait.current);
    const made = body();
    if (!made || spent.value || busy) return;
    spent.value = true;
    void onKeep(made).then((kept) => kept || (spent.value = false));
  };
  // What is typed is shown on the limb once the hand rests.
  const change = () => {
    spent.value = false;
    meanwhile.current = busy;
    clearTimeout(wait.current);
    wait.current = window.setTimeout(() => {
      const made = latest.current();
      if (made) onTry(made);
    }, TRY_AFTER_MS);
  };
  // What was typed while another one was being kept is tried after it.
  useEffect(() => {
    if (!busy && meanwhile.current) change();
  }, [busy]);
  const latest = useRef<() => EditBody | null>(() => null);
  latest.current = () => (lacks.length ? null : body());
  const set = (name: string, value: string) => {
    given.value = { ...given.value, [name]: value };
    change();
  };
  const onEnter = (event: KeyboardEvent) => event.key === "Enter" && !lacks.length && keep();
  return (
    <section class="edit other-edit">
      <h2>{t(only ? "tool.levels" : "tool.other")}</h2>
      <span class="field">
        <select
          aria-label={t("tool.other")}
          value={one?.kind ?? ""}
          onChange={(event) => {
            clearTimeout(wait.current);
            kind.value = event.currentTarget.value;
            spent.value = false;
            given.value = {};
            onDrop();
          }}
        >
          {groups.map((group) => {
            const own = all.filter((k) => k.group === group);
            return (
              <optgroup key={group} label={groupOf(own[0].kind)}>
                {own.map((k) => (
                  <option key={k.kind} value={k.kind}>
                    {editName(k.kind)}
                  </option>
                ))}
              </optgroup>
            );
          })}
        </select>
      </span>
      {one && <p class="soft small-note">{purposeOf(one.kind)}</p>}
      {byLevels && one && <LevelRows kind={one.kind} levels={levels} onChange={change} onKeyDown={onEnter} />}
      {fields.map((p) => (
        <label key={p.name} class="stacked">
          <span>{labelOf(one?.kind ?? "", p.name)}</span>
          <Field kind={one?.kind ?? ""} parameter={p} value={given.value[p.name]} places={places} onValue={(value) => set(p.name, value)} onKeyDown={onEnter} />
          <span class="small faint">{[helpOf(one?.kind ?? "", p.name), rangeOf(p)].filter(Boolean).join(" ")}</span>
        </label>
      ))}
      <Refusal refused={refused} />
      {(volume_ml !== null || waits) && (
        <div class={`eff ${waits ? "waits" : ""}`} role="status">
          <span>
            {t("volume")} <b class={(volume_ml ?? 0) < 0 ? "neg" : "pos"}>{volume_ml === null ? "…" : `${signed(volume_ml)} mL`}</b>
          </span>
        </div>
      )}
      <div class="acts">
        <Button
          go
          class="grow"
          off={busy ? t("loading") : spent.value ? t("other.kept") : lacks.length ? t("other.lacks", lacks.join(", ")) : refused ? t("refused.first") : null}
          onClick={keep}
        >
          {t("keep")}
        </Button>
        {volume_ml !== null && <Button onClick={onDrop}>{t("drop.edit")}</Button>}
      </div>
      {lacks.length > 0 && <p class="small faint">{t("other.lacks", lacks.join(", "))}</p>}
    </section>
  );
}
