/** A template's picture and file, and how it is deleted. */
import { useSignal } from "@preact/signals";

import { ROOT, type Schemas } from "../../api/client";
import { Confirm } from "../../design/parts";
import { t } from "../../texts";

interface Props {
  readonly template: Schemas["TemplateReply"];
  readonly onRemove: () => Promise<unknown>;
}

export function FileOf({ template, onRemove }: Props) {
  const removing = useSignal(false);
  return (
    <>
      <p class="small template-links">
        {!template.finding && (
          <a href={`${ROOT}/templates/${template.id}/picture`} target="_blank" rel="noreferrer">
            {t("template.picture")}
          </a>
        )}
        <a href={`${ROOT}/templates/${template.id}/file`} download={`${template.name}.json`}>
          {t("template.file")}
        </a>
        <button type="button" class="linkish" onClick={() => (removing.value = true)}>
          {t("delete")}
        </button>
      </p>
      {removing.value && (
        <Confirm
          danger
          title={t("delete.sure", template.name)}
          yes={t("delete")}
          onYes={() => void onRemove().then(() => (removing.value = false))}
          onNo={() => (removing.value = false)}
        >
          <p>{t("template.delete.what")}</p>
        </Confirm>
      )}
    </>
  );
}
