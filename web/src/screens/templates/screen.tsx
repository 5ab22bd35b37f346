/**
 * Templates: what this clinic did to several limbs, learned and done to the next one.
 *
 * A template is tried and kept as any edit is: the recipe holds the whole of it, undo takes it back.
 */
import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";

import { type Refused, type Schemas, answerOf, api, putFile } from "../../api/client";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { perform } from "../../state/acts";
import { useAct, useQuery } from "../../state/requests";
import { expert } from "../../state/settings";
import { t } from "../../texts";
import { sentences } from "../edit-words";
import type { EditBody } from "../rectify/draft";
import type { OpenCase } from "../open-case";
import { useChosen } from "./chosen";
import { FileOf } from "./file-of";
import { Learning } from "./learning";
import { WhatItDoes } from "./what-it-does";

interface Props {
  readonly openCase: OpenCase;
  /** Whether the server's trial of the edit stands on the limb. */
  readonly tried: boolean;
  readonly waits: boolean;
  readonly refused: Refused | null;
  readonly busy: boolean;
  readonly onTry: (edit: EditBody) => void;
  readonly onKeep: (edit: EditBody) => void;
  readonly onDrop: () => void;
}

export function TemplateEdits({ openCase, tried, waits, refused, busy, onTry, onKeep, onDrop }: Props) {
  const list = useQuery(() => answerOf(api.GET("/api/v1/templates", {})), []);
  const learning = useSignal(false);
  const notes = useSignal<readonly Schemas["FindingReply"][]>([]);
  const act = useAct();
  const all = list.value.value ?? [];
  const isReadable = (id: string) => all.some((k) => k.id === id && !k.finding);
  const { id: chosen, strength, edit } = useChosen(act, isReadable, onTry);
  const input = useRef<HTMLInputElement>(null);
  const one = all.find((k) => k.id === chosen.value) ?? null;

  const leave = () => {
    chosen.value = "";
    onDrop();
  };
  const take = (file: File) =>
    act.run(async () => {
      await putFile("/templates/file", file);
      await list.again();
    });
  const remove = () =>
    act.run(async () => {
      await perform("", "delete", "/api/v1/templates/{template_id}", { params: { path: { template_id: chosen.value } } });
      leave();
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
                  {k.finding ? k.name : `${k.name} (${t("template.cases", k.pairs)})`}
                </option>
              ))}
            </select>
          </span>
        </label>
      )}
      {one?.finding && (
        <>
          <p class="small-note" role="status">
            {sentences(one.finding)}
          </p>
          <div class="acts">
            <Button onClick={leave}>{t("drop.edit")}</Button>
          </div>
          <FileOf template={one} onRemove={remove} />
        </>
      )}
      {one && !one.finding && (
        <>
          <WhatItDoes template={one} strength={strength} />
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
              {t("keep")}
            </Button>
            <Button onClick={leave}>{t("drop.edit")}</Button>
          </div>
          <FileOf template={one} onRemove={remove} />
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
            aria-label={t("take.in.file")}
            onChange={(event) => {
              const file = event.currentTarget.files?.[0];
              if (file) void take(file);
              event.currentTarget.value = "";
            }}
          />
          <Button onClick={() => input.current?.click()}>{t("take.in.file")}</Button>
        </div>
      )}
      {!one && learning.value && (
        <Learning
          openCase={openCase}
          onLearned={(reply) => {
            list.put(reply.templates);
            notes.value = reply.notes;
            learning.value = false;
          }}
        />
      )}
      {expert.value && notes.value.length > 0 && (
        <ul class="findings small-note soft">
          {notes.value.map((one) => (
            <li key={sentences(one)}>{sentences(one)}</li>
          ))}
        </ul>
      )}
    </section>
  );
}
