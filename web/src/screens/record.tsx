/** Record: what is kept and signed. The sheets as they are printed, and the reports of the capture. */
import { useSignal } from "@preact/signals";

import { ROOT } from "../api/client";
import { Icon } from "../design/icons";
import { Segments } from "../design/parts";
import { t } from "../texts";
import type { CaseProps } from "./open-case";

type Sheet = "record" | "report" | "accuracy";

export function RecordScreen({ openCase }: CaseProps) {
  const sheet = useSignal<Sheet>("record");
  const base = `${ROOT}/cases/${openCase.id}`;
  /** The sheet that is here: making one takes some seconds, and an empty frame says nothing. */
  const ready = useSignal("");
  const source = { record: `${base}/record.html`, report: `${base}/report/report`, accuracy: `${base}/report/accuracy` }[sheet.value];
  return (
    <div class="work">
      <main class="record-main" id="content" tabIndex={-1}>
        <div class="row-head">
          <h1>{t(`record.${sheet.value}`)}</h1>
          <span class="grow" />
          <Segments
            label={t("step.record")}
            value={sheet.value}
            options={(["record", "report", "accuracy"] as const).map((value) => ({ value, text: t(`record.${value}`) }))}
            onChange={(value) => (sheet.value = value)}
          />
        </div>
        {ready.value !== source && (
          <p class="soft" role="status">
            {t("record.making")}
          </p>
        )}
        <iframe key={source} class="sheet" src={source} title={t(`record.${sheet.value}`)} onLoad={() => (ready.value = source)} />
      </main>
      <aside class="pane" aria-label={t("step.record")}>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <h2>{t("record.title")}</h2>
            <p class="soft">{t("record.how")}</p>
          </section>
          <section>
            <h3>{t("record.kept")}</h3>
            <ul class="earlier">
              {openCase.info.steps.map((step) => (
                <li key={step.name}>
                  <span>{t(`step.${step.name}`)}</span>
                  <span class="faint small">{step.state === "done" ? <Icon name="tick" small /> : ""}</span>
                </li>
              ))}
            </ul>
          </section>
        </div>
        <div class="next">
          <a class="btn go big" href={`${base}/record.pdf`} target="_blank" rel="noreferrer">
            <Icon name="print" />
            {t("record.pdf")}
          </a>
          <p class="small faint">{t("record.pdf.how")}</p>
        </div>
      </aside>
    </div>
  );
}
