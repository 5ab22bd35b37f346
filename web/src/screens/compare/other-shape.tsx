/** The other shape: a state of this one, another case, or a file that is sent. */
import type { Signal } from "@preact/signals";
import { useRef } from "preact/hooks";

import { answerOf, api, putFile } from "../../api/client";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { shapeFiles } from "../../formats";
import { kindName } from "../../limb-kinds";
import { bytes } from "../../numbers";
import { perform } from "../../state/acts";
import { useAct, useQuery } from "../../state/requests";
import { t } from "../../texts";
import { summaryOf } from "../edit-words";
import type { OpenCase } from "../open-case";
import { type Against, keyOf } from "./against";
import { shapeFileName } from "./file-name";

interface Props {
  readonly openCase: OpenCase;
  readonly against: Signal<Against | null>;
  /** Whether it may be the scan of this case. */
  readonly scan: boolean;
  /** Whether it may be this shape before one of its edits. */
  readonly before: boolean;
}

export function OtherShape({ openCase, against, scan, before }: Props) {
  const path = { params: { path: { case_id: openCase.id } } };
  const act = useAct();
  const input = useRef<HTMLInputElement>(null);
  const others = useQuery(
    async () => (await answerOf(api.GET("/api/v1/cases", { params: { query: {} } }))).cases.filter((one) => one.id !== openCase.id && one.verdict),
    [openCase.id],
  );
  const recipe = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/recipe", path)), [openCase.id, openCase.changes.work]);
  const files = useQuery(() => answerOf(api.GET("/api/v1/cases/{case_id}/shapes", path)), [openCase.id]);
  const send = (file: File) =>
    act.run(async () => {
      const name = shapeFileName(file.name);
      await putFile(`/cases/${openCase.id}/shapes/${encodeURIComponent(name)}`, file);
      await files.again();
      against.value = { what: "file", name };
    });
  const forget = (name: string) =>
    act.run(async () => {
      await perform(openCase.id, "delete", "/api/v1/cases/{case_id}/shapes/{name}", { params: { path: { case_id: openCase.id, name } } });
      against.value = null;
      await files.again();
    });
  const edits = before ? (recipe.value.value?.edits ?? []).slice(1) : [];
  const choices: readonly (readonly [Against, string])[] = [
    ...(scan ? [[{ what: "scan" }, t("compare.scan")] as const] : []),
    ...edits.map((one) => [{ what: "before", edit: one.number }, t("compare.before.edit", one.number, summaryOf(one).title)] as const),
    ...(others.value.value ?? []).map(({ id, kind, side }) => {
      const sideWords = side === "left" || side === "right" ? t(`side.${side}`) : "";
      return [{ what: "case", id }, [id, kindName(kind), sideWords].filter(Boolean).join(", ")] as const;
    }),
    ...(files.value.value ?? []).map((file) => [{ what: "file", name: file.name }, `${file.name} (${bytes(file.bytes)})`] as const),
  ];
  const choose = (key: string) => (against.value = choices.find(([one]) => keyOf(one) === key)?.[0] ?? null);
  const now = against.value;
  return (
    <section>
      <h2>{t("compare.with.what")}</h2>
      <label class="stacked">
        <span>{t("compare.with")}</span>
        <span class="field">
          <select value={keyOf(now)} onChange={(event) => choose(event.currentTarget.value)}>
            <option value="">{t("choose")}</option>
            {choices.map(([one, words]) => (
              <option key={keyOf(one)} value={keyOf(one)}>
                {words}
              </option>
            ))}
          </select>
        </span>
      </label>
      <input
        ref={input}
        class="unseen"
        type="file"
        tabIndex={-1}
        accept={shapeFiles.value.join(",")}
        id="shape-file"
        aria-label={t("take.in.file")}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          if (file) void send(file);
          event.currentTarget.value = "";
        }}
      />
      <div class="acts">
        <Button icon="folder" off={act.busy.value && t("loading")} onClick={() => input.current?.click()}>
          {t("take.in.file")}
        </Button>
        {now?.what === "file" && <Button onClick={() => void forget(now.name)}>{t("compare.forget")}</Button>}
      </div>
      <p class="small faint">{t("compare.file.how")}</p>
      <Refusal refused={act.refused.value ?? others.refused.value ?? recipe.refused.value ?? files.refused.value} />
    </section>
  );
}
