/** Files that were written before. */
import type { Schemas } from "../../api/client";
import { t, when } from "../../texts";
import { madeOf } from "./made-of";

export function Earlier({ files }: { files: readonly Schemas["ExportedFile"][] }) {
  return (
    <>
      <section>
        <h2>{t("send.before")}</h2>
        <p class="soft small-note">{t("send.before.how")}</p>
      </section>
      {files.length > 0 && (
        <section>
          <h3>{t("send.earlier")}</h3>
          <ul class="earlier">
            {files.slice(0, 8).map((one) => (
              <li key={one.name + one.made}>
                <span>{one.name}</span>
                <span class="faint small">{when(one.made)}</span>
                <span class="faint small made-of">{madeOf(one)}</span>
              </li>
            ))}
          </ul>
        </section>
      )}
    </>
  );
}
