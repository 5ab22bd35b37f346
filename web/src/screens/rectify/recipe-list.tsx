/** The recipe: the list of what can be changed, moved, switched off and undone. */
import { useSignal } from "@preact/signals";

import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Button, Notice, NumberField, Switch } from "../../design/parts";
import { signed } from "../../numbers";
import { expert } from "../../state/settings";
import { t } from "../../texts";
import { sentences, summaryOf } from "../edit-words";
import { type Shown, movedTo } from "../recipe-acts";
import { toneOf } from "./effect";
import { type Ledgered, changed } from "./ledger";
import type { RecipeChanges } from "./recipe-changes";

type Line = NonNullable<Ledgered["ledger"]>["lines"][number];

interface ListProps {
  readonly book: Ledgered;
  /** The edits once the pending changes are done; null: until the answer no number means an edit. */
  readonly listed: readonly Shown[] | null;
  readonly recipe: RecipeChanges;
}

export function RecipeList({ book, listed, recipe }: ListProps) {
  const chosen = useSignal<number | null>(null);
  const lines = book.ledger?.lines ?? [];
  const { fits, notes } = book.recipe;
  const unknown = listed === null;
  const edits = listed ?? book.recipe.edits.map((one): Shown => ({ ...one, was: null }));
  const change = (number: number, body: Schemas["EditChange"]) => {
    if (chosen.value !== null && body.number) chosen.value = movedTo(chosen.value, number, body.number);
    recipe.change(number, body);
  };
  const remove = (number: number) => {
    chosen.value = null; // the next edit has its number now
    recipe.remove(number);
  };
  return (
    <section class="recipe">
      <Head book={book} recipe={recipe} />
      {!fits && !book.refusal && (
        <Notice tone="amber" title={t("recipe.fits.not")}>
          {t("recipe.fits.not.do")}
        </Notice>
      )}
      {edits.length === 0 && <p class="soft small-note">{t("recipe.empty")}</p>}
      <ol class={`edits ${unknown ? "waits" : ""}`} aria-busy={unknown || undefined} inert={unknown}>
        {edits.map((one) => (
          <Row
            key={one.number}
            one={one}
            count={edits.length}
            line={lines.find((line) => line.number === one.was)}
            chosen={chosen.value === one.number}
            onChoose={(on) => (chosen.value = on ? one.number : null)}
            onChange={change}
            onRemove={remove}
          />
        ))}
      </ol>
      {notes.map((one) => (
        <p key={sentences(one)} class="small soft">
          {sentences(one)}
        </p>
      ))}
    </section>
  );
}

function Head({ book, recipe }: { book: Ledgered; recipe: RecipeChanges }) {
  const { can_undo, can_redo } = book.recipe;
  return (
    <div class="row-head">
      <h2>{t("recipe")}</h2>
      <span class="grow" />
      <span class="small faint ml">mL</span>
      <Button bare icon="undo" class="icon-only" label={t("undo")} off={can_undo ? null : t("nothing.undo")} onClick={recipe.undo} />
      <Button bare icon="redo" class="icon-only" label={t("redo")} off={can_redo ? null : t("nothing.redo")} onClick={recipe.redo} />
    </div>
  );
}

interface RowProps {
  readonly one: Shown;
  /** How many edits there are. */
  readonly count: number;
  /** What the ledger says of it. */
  readonly line: Line | undefined;
  readonly chosen: boolean;
  readonly onChoose: (on: boolean) => void;
  readonly onChange: (number: number, body: Schemas["EditChange"]) => void;
  readonly onRemove: (number: number) => void;
}

function Row({ one, count, line, chosen, onChoose, onChange, onRemove }: RowProps) {
  const words = summaryOf(one);
  const change_ml = line && one.on ? changed(line.volume) : null;
  return (
    <li class={`ed ${one.on ? "" : "offd"} ${chosen ? "on" : ""}`} {...dragged(one.number, onChange)}>
      <Grip number={one.number} count={count} onChange={onChange} />
      <Switch on={one.on} label={`${one.number} ${words.title}`} onChange={(on) => onChange(one.number, { on })} />
      <button type="button" class="ed-name" aria-expanded={chosen} onClick={() => onChoose(!chosen)}>
        {one.number}&ensp;{words.title}
        <em>{words.where}</em>
      </button>
      <span class="num">{words.amount}</span>
      <span class={`num ${change_ml === null ? "" : toneOf(change_ml)}`}>
        {!one.on ? t("off").toLowerCase() : change_ml !== null ? signed(change_ml) : one.was === null ? "…" : ""}
      </span>
      {line && line.told.length > 0 && !chosen && <p class="ed-more small soft">{line.told.map(sentences).join(" ")}</p>}
      {chosen && <More one={one} line={line} onChange={onChange} onRemove={onRemove} />}
    </li>
  );
}

/** A row is moved by dropping it on another one. */
function dragged(number: number, onChange: RowProps["onChange"]) {
  return {
    draggable: true,
    onDragStart: (event: DragEvent) => event.dataTransfer?.setData("text/plain", String(number)),
    onDragOver: (event: DragEvent) => event.preventDefault(),
    onDrop: (event: DragEvent) => {
      event.preventDefault();
      const from = Number(event.dataTransfer?.getData("text/plain"));
      if (from && from !== number) onChange(from, { number });
    },
  };
}

/** By which a row is moved; also with the arrows. */
function Grip({ number, count, onChange }: Pick<RowProps, "count" | "onChange"> & { number: number }) {
  const onKey = (event: KeyboardEvent) => {
    const by = event.key === "ArrowUp" ? -1 : event.key === "ArrowDown" ? 1 : 0;
    const to = number + by;
    if (!by || to < 1 || to > count) return;
    event.preventDefault();
    onChange(number, { number: to });
    // The rows stay where they are and what they show moves: so does the focus.
    const row = (event.currentTarget as HTMLElement).closest("li");
    (by < 0 ? row?.previousElementSibling : row?.nextElementSibling)?.querySelector<HTMLElement>(".grip")?.focus();
  };
  return (
    <button type="button" class="grip" aria-label={t("recipe.move", number)} onKeyDown={onKey}>
      <Icon name="grip" small />
    </button>
  );
}

/** All that is known of an edit, its number to change, and how to take it out. */
function More({ one, line, onChange, onRemove }: Pick<RowProps, "one" | "line" | "onChange" | "onRemove">) {
  const parameters = one.parameters as Record<string, never>;
  return (
    <div class="ed-more">
      {summaryOf(one).field && (
        <NumberField
          label={t("depth")}
          unit="mm"
          step={0.1}
          decimals={2}
          min={0.1}
          max={60}
          value={Number(parameters.depth_mm)}
          onChange={(depth_mm) => onChange(one.number, { parameters: { ...parameters, depth_mm } as never })}
        />
      )}
      {expert.value && <p class="mono">{one.text}</p>}
      {line?.told.map((finding) => (
        <p key={sentences(finding)} class="small faint">
          {sentences(finding)}
        </p>
      ))}
      <Button onClick={() => onRemove(one.number)}>{t("take.out")}</Button>
    </div>
  );
}
