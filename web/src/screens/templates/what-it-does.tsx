/** How strongly a template is applied, and how far it moves the places of the limb. */
import type { Signal } from "@preact/signals";

import type { Schemas } from "../../api/client";
import { NumberField } from "../../design/parts";
import { fixed, signed } from "../../numbers";
import { t } from "../../texts";
import { term } from "../../words";

interface Props {
  readonly template: Schemas["TemplateReply"];
  /** Per cent. */
  readonly strength: Signal<number>;
}

export function WhatItDoes({ template, strength }: Props) {
  return (
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
      <p class="soft small-note">
        {t("template.range", signed(template.most_inward_mm), signed(template.most_outward_mm), fixed(100 * template.changed_share, 0))}
      </p>
      {template.places.length > 0 && (
        <table class="kv">
          <tbody>
            {template.places.map((move) => (
              <tr key={move.place}>
                <td>{term(move.place)}</td>
                <td class={move.moved_mm < -0.05 ? "neg" : move.moved_mm > 0.05 ? "pos" : ""}>{signed((move.moved_mm * strength.value) / 100)} mm</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </>
  );
}
