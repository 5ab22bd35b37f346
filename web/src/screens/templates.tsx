/**
 * Templates: what this clinic did to several limbs, learned and done to the next one.
 *
 * A template is tried and kept as any edit is: the recipe holds the whole of it, undo takes it back.
 */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";

import { ROOT, Refused, type Schemas, api, bytesOf, note, refusedBy, taken } from "../api/client";
import { Button, Chip, Confirm, NumberField } from "../design/parts";
import { Refusal } from "../design/refusal";
import { signed } from "../geometry/scales";
import { kindName } from "../limb-kinds";
import { newOffer, perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { expert } from "../state/settings";
import { t } from "../texts";
import { term } from "../words";
import { said } from "./edit-words";
import type { Room } from "./room";

export interface TemplateEdit {
  readonly kind: "from-template";
  readonly parameters: { readonly learned: string; readonly strength: number };
  readonly accept: string[];
}

interface Props {
  readonly room: Room;
  /** Whether the server's trial of the edit stands on the limb. */
  readonly tried: boolean;
  readonly waits: boolean;
  readonly refused: Refused | null;
  readonly busy: boolean;
  readonly onTry: (edit: TemplateEdit) => void;
  readonly onKeep: (edit: TemplateEdit) => void;
  readonly onDrop: () => void;
}

export function TemplateEdits({ room, tried, waits, refused, busy, onTry, onKeep, onDrop }: Props) {
  const list = useAsked(() => taken(api.GET("/api/v1/templates", {})), []);
  const chosen = useSignal("");
  const strength = useSignal(100);
  const learned = useRef<{ id: string; text: string } | null>(null);
  const learning = useSignal(false);
  const removing = useSignal(false);
  const notes = useSignal<readonly Schemas["FindingReply"][]>([]);
  const act = useAct();
  const input = useRef<HTMLInputElement>(null);
  const all = list.value.value ?? [];
  const one = all.find((k) => k.id === chosen.value) ?? null;

  const edit = async (): Promise<TemplateEdit> => {
    if (learned.current?.id !== chosen.value)
      learned.current = { id: chosen.value, text: new TextDecoder().decode((await bytesOf(`/templates/${chosen.value}/file`)).bytes) };
    return { kind: "from-template", parameters: { learned: learned.current.text, strength: strength.value / 100 }, accept: [] };
  };
  useEffect(() => {
    if (chosen.value) void act.run(async () => onTry(await edit()));
  }, [chosen.value, strength.value]);
  const take = (file: File) =>
    act.run(async () => {
      const response = await fetch(`${ROOT}/templates/file`, {
        method: "PUT",
        body: file,
        headers: { "Content-Type": "application/octet-stream" },
        credentials: "same-origin",
      }).catch(() => null);
      if (!response) throw new Refused("Lost", t("lost"), 0);
      note(response.status);
      if (!response.ok) throw refusedBy(response.status, await response.json().catch(() => null));
      await list.again();
    });
  const remove = () =>
    act.run(async () => {
      await perform("", "delete", "/api/v1/templates/{template_id}", { params: { path: { template_id: chosen.value } } });
      removing.value = false;
      chosen.value = "";
      onDrop();
      await list.again();
    });

  return (
    <section class="edit">
      <h2>{t("template.title")}</h2>
      <Refusal refused={list.refused.value ?? act.refused.value} />
      {list.value.value && all.length === 0 && <p class="soft small-note">{t("template.none")}</p>}
      {all.length > 0 && (
        <label class="stacked">
          <span>{t("template.which")}</span>
          <span class="field">
            <select
              value={chosen.value}
              onChange={(event) => {
                chosen.value = event.currentTarget.value;
                if (!chosen.value) onDrop();
              }}
            >
              <option value="">{t("choose")}</option>
              {all.map((k) => (
                <option key={k.id} value={k.id}>
                  {k.name} ({t("template.cases", k.pairs)})
                </option>
              ))}
            </select>
          </span>
        </label>
      )}
      {one && (
        <>
          <NumberField
            label={t("template.strength")}
            unit="%"
            step={10}
            decimals={0}
            min={10}
            max={300}
            value={strength.value}
            onChange={(value) => (strength.value = value)}
          />
          <p class="soft small-note">{t("template.range", signed(one.most_inward_mm), signed(one.most_outward_mm), (100 * one.changed_share).toFixed(0))}</p>
          {one.places.length > 0 && (
            <table class="kv">
              <tbody>
                {one.places.map((move) => (
                  <tr key={move.place}>
                    <td>{term(move.place)}</td>
                    <td class={move.moved_mm < -0.05 ? "neg" : move.moved_mm > 0.05 ? "pos" : ""}>{signed((move.moved_mm * strength.value) / 100)} mm</td>
                  </tr>
                ))}
              </tbody>
            </table>
          )}
          <Refusal refused={refused} />
          {waits && (
            <p class="soft small-note" role="status">
              {t("template.trying")}
            </p>
          )}
          <div class="acts">
            <Button
              go
              class="grow"
              off={busy || waits ? t("loading") : tried ? null : t("refused.first")}
              onClick={() => void act.run(async () => onKeep(await edit()))}
            >
              {t("keep.edit")}
            </Button>
            <Button
              onClick={() => {
                chosen.value = "";
                onDrop();
              }}
            >
              {t("drop.edit")}
            </Button>
          </div>
          <p class="small template-links">
            <a href={`${ROOT}/templates/${one.id}/picture`} target="_blank" rel="noreferrer">
              {t("template.picture")}
            </a>
            <a href={`${ROOT}/templates/${one.id}/file`} download={`${one.name}.json`}>
              {t("template.file")}
            </a>
            <button type="button" class="linkish" onClick={() => (removing.value = true)}>
              {t("cameras.delete")}
            </button>
          </p>
          {removing.value && (
            <Confirm
              danger
              title={t("cameras.delete.sure", one.name)}
              yes={t("cameras.delete")}
              onYes={() => void remove()}
              onNo={() => (removing.value = false)}
            >
              <p>{t("template.delete.what")}</p>
            </Confirm>
          )}
        </>
      )}
      {!one && (
        <div class="acts">
          <Button onClick={() => (learning.value = !learning.value)} pressed={learning.value}>
            {t("template.learn")}
          </Button>
          <input
            ref={input}
            class="unseen"
            type="file"
            tabIndex={-1}
            accept=".json"
            aria-label={t("template.take")}
            onChange={(event) => {
              const file = event.currentTarget.files?.[0];
              if (file) void take(file);
              event.currentTarget.value = "";
            }}
          />
          <Button onClick={() => input.current?.click()}>{t("template.take")}</Button>
        </div>
      )}
      {!one && learning.value && (
        <Learning
          room={room}
          onLearned={(reply) => {
            list.value.value = reply.templates;
            notes.value = reply.notes;
            learning.value = false;
          }}
        />
      )}
      {expert.value && notes.value.length > 0 && (
        <ul class="findings small-note soft">
          {notes.value.map((one) => (
            <li key={said(one)}>{said(one)}</li>
          ))}
        </ul>
      )}
    </section>
  );
}

/** Which cases a template is learned from, and what it is called. */
function Learning({ room, onLearned }: { room: Room; onLearned: (reply: Schemas["LearnedReply"]) => void }) {
  const cases = useAsked(
    async () =>
      (await taken(api.GET("/api/v1/cases", { params: { query: {} } }))).cases.filter((one) =>
        one.steps.some((step) => step.name === "rectify" && step.state !== "locked" && step.count > 0),
      ),
    [],
  );
  const name = useSignal("");
  const ticked = useSignal<ReadonlySet<string>>(new Set([room.id]));
  const act = useAct();
  const offer = useMemo(newOffer, []);
  const list = cases.value.value ?? [];
  const chosen = list.filter((one) => ticked.value.has(one.id)).map((one) => one.id);
  const learn = () =>
    act.run(async () => {
      const body = { name: name.value.trim(), cases: chosen };
      onLearned(await perform("", "post", "/api/v1/templates", { body }, { id: offer.idOf(body), lane: "learn templates" }));
    });
  return (
    <div class="learning">
      <label class="stacked" inert={act.busy.value}>
        <span>{t("template.name")}</span>
        <span class="field">
          <input maxLength={80} value={name.value} onInput={(event) => (name.value = event.currentTarget.value)} />
        </span>
      </label>
      <fieldset inert={act.busy.value}>
        <legend>{t("template.from")}</legend>
        {cases.value.value && list.length === 0 && <p class="soft small-note">{t("template.from.none")}</p>}
        {list.map((one) => (
          <label key={one.id} class="check-line">
            <input
              type="checkbox"
              checked={ticked.value.has(one.id)}
              onChange={(event) => {
                const next = new Set(ticked.value);
                if (event.currentTarget.checked) next.add(one.id);
                else next.delete(one.id);
                ticked.value = next;
              }}
            />
            {one.id} {kindName(one.kind)} {one.side === "left" || one.side === "right" ? t(`side.${one.side}`) : ""}
          </label>
        ))}
      </fieldset>
      <p class="small faint">{t(chosen.length < 5 ? "template.few" : "template.several")}</p>
      <Refusal refused={act.refused.value ?? cases.refused.value} />
      <div class="acts">
        <Button
          go
          off={act.busy.value ? t("template.busy") : !name.value.trim() ? t("template.name") : chosen.length ? null : t("template.from")}
          onClick={() => void learn()}
        >
          {t("template.learn.now", chosen.length)}
        </Button>
        {act.busy.value && <Chip tone="plain">{t("template.busy")}</Chip>}
      </div>
    </div>
  );
}
