/** Files that the server did not take, each with its reason. */
import { Button, Notice } from "../design/parts";
import { type Upload, forgetDone } from "../state/uploads";
import { t } from "../texts";

export function RefusedFiles({ caseId, refused }: { caseId: string; refused: readonly Upload[] }) {
  if (!refused.length) return null;
  return (
    <Notice tone="red" title={t("capture.refused.some")} action={<Button onClick={() => forgetDone(caseId)}>{t("close")}</Button>}>
      {refused.map((one) => (
        <p key={one.name}>
          <b>{one.name}</b>: {one.message}
        </p>
      ))}
    </Notice>
  );
}
