/** Help beside each step: what it is for, and what the hands do. */
import { Button } from "../design/parts";
import { type TextKey, t, tOr } from "../texts";

const LINES = 4;

export function HelpPanel({ topic, onClose }: { topic: string; onClose: () => void }) {
  const lines = Array.from({ length: LINES }, (_, i) => tOr(`help.${topic}.${i + 1}`, "")).filter(Boolean);
  const hands: [TextKey, TextKey][] = [
    ["hand.turn", "hand.turn.how"],
    ["hand.move", "hand.move.how"],
    ["hand.near", "hand.near.how"],
    ["hand.fit", "hand.fit.how"],
    ["hand.views", "hand.views.how"],
    ["parallel", "hand.parallel.how"],
    ["hand.undo", "hand.undo.how"],
  ];
  const work = ["compare", "result", "align", "measure", "rectify"].includes(topic);
  return (
    <aside class="pane help-pane" aria-label={t("help")}>
      <div class="scroll">
        <section>
          <div class="row-head">
            <h2>{t("help.about", tOr(`step.${topic}`, tOr(topic, topic)))}</h2>
            <span class="grow" />
            <Button bare icon="close" class="icon-only" label={t("close")} onClick={onClose} />
          </div>
          {lines.map((line) => (
            <p key={line} class="help-line">
              {line}
            </p>
          ))}
        </section>
        {work && (
          <section>
            <h3>{t("hand.title")}</h3>
            <table class="kv">
              <tbody>
                {hands.map(([what, how]) => (
                  <tr key={what}>
                    <td>{t(what)}</td>
                    <td>{t(how)}</td>
                  </tr>
                ))}
              </tbody>
            </table>
          </section>
        )}
      </div>
    </aside>
  );
}
