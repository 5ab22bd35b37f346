/** The parts that every screen is made of. */
import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";

import { numberIn, typedAs } from "../numbers";
import { t } from "../texts";
import { Icon, type IconName } from "./icons";

export type Side = "left" | "right" | "none" | null | undefined;
export type Verdict = "green" | "amber" | "red";

/** The side by letter and word: left filled with its letter left, right outlined with its letter right. */
export function SideBadge({ side }: { side: Side }) {
  if (side !== "left" && side !== "right") return <span class="unit">{t("side.unknown")}</span>;
  return (
    <span class={`side ${side === "right" ? "right" : ""}`} role="img" aria-label={t(side === "left" ? "side.left.long" : "side.right.long")}>
      <b>{t(side === "left" ? "side.L" : "side.R")}</b>
      {t(side === "left" ? "side.LEFT" : "side.RIGHT")}
    </span>
  );
}

const CHIP_ICONS: Record<string, IconName> = { green: "ok", amber: "warn", red: "stop" };

export function Chip({ tone, children }: { tone: Verdict | "plain"; children: ComponentChildren }) {
  const icon = CHIP_ICONS[tone];
  return (
    <span class={`chip ${tone}`}>
      {icon && <Icon name={icon} />}
      {children}
    </span>
  );
}

interface ButtonProps {
  children?: ComponentChildren;
  icon?: IconName;
  go?: boolean;
  big?: boolean;
  bare?: boolean;
  danger?: boolean;
  /** Why it is switched off; it stays reachable by keyboard and says so. */
  off?: string | false | null;
  onClick?: (event: MouseEvent) => void;
  label?: string;
  trailing?: IconName;
  class?: string;
  pressed?: boolean;
  id?: string;
}

export function Button({ children, icon, go, big, bare, danger, off, onClick, label, trailing, class: more = "", pressed, id }: ButtonProps) {
  const why = useId();
  return (
    <>
      <button
        type="button"
        id={id}
        class={`btn ${go ? "go" : ""} ${big ? "big" : ""} ${bare ? "bare" : ""} ${danger ? "danger" : ""} ${off ? "off" : ""} ${more}`}
        aria-disabled={off ? true : undefined}
        aria-describedby={off ? why : undefined}
        aria-label={label}
        aria-pressed={pressed}
        title={off || undefined}
        onClick={(event) => {
          if (!off) onClick?.(event);
        }}
      >
        {icon && <Icon name={icon} />}
        {children}
        {trailing && <Icon name={trailing} />}
      </button>
      {off && (
        <span id={why} class="unseen">
          {off}
        </span>
      )}
    </>
  );
}

/** One of a few: radio buttons that look like one bar. */
export function Segments<T extends string>({
  value,
  options,
  onChange,
  label,
}: {
  value: T;
  options: readonly { readonly value: T; readonly text: string; readonly off?: string }[];
  onChange: (value: T) => void;
  label: string;
}) {
  const group = useId();
  return (
    <div class="seg" role="radiogroup" aria-label={label}>
      {options.map((one) => (
        <label key={one.value} class={`${one.value === value ? "on" : ""} ${one.off ? "off" : ""}`} title={one.off}>
          <input type="radio" name={group} value={one.value} checked={one.value === value} disabled={Boolean(one.off)} onChange={() => onChange(one.value)} />
          {one.text}
        </label>
      ))}
    </div>
  );
}

/** A number with its unit inside the field, and steps. What is typed counts on Enter or on leaving. */
export function NumberField({
  label,
  value,
  unit,
  step = 0.1,
  min,
  max,
  decimals = 1,
  onChange,
  off,
  hideLabel,
}: {
  label: string;
  value: number | null;
  unit: string;
  step?: number;
  min?: number;
  max?: number;
  decimals?: number;
  onChange: (value: number) => void;
  off?: string;
  hideLabel?: boolean;
}) {
  const id = useId();
  const bounded = (x: number) => Number(Math.min(max ?? Infinity, Math.max(min ?? -Infinity, x)).toFixed(decimals));
  const typed = useTyped(value === null || !Number.isFinite(value) ? "" : typedAs(Number(value.toFixed(decimals))), (x) => x !== null && onChange(x), {
    bounded,
  });
  const by = (steps: number) => typed.keep((numberIn(typed.now()) ?? 0) + steps * step);
  return (
    <div class="number">
      <label for={id} class={hideLabel ? "unseen" : ""}>
        {label}
      </label>
      <span class="field">
        <input
          id={id}
          inputMode="decimal"
          autocomplete="off"
          {...typed.input}
          disabled={Boolean(off)}
          title={off}
          onKeyDown={(event) => {
            if (event.key === "Enter") typed.commit();
            else if (event.key === "ArrowUp") by(event.shiftKey ? 10 : 1);
            else if (event.key === "ArrowDown") by(event.shiftKey ? -10 : -1);
            else return;
            if (event.key !== "Enter") event.preventDefault();
          }}
        />
        <span class="u">{unit}</span>
        {!off && (
          <span class="st">
            <button type="button" tabIndex={-1} aria-label={t("less", label)} onClick={() => by(-1)}>
              −
            </button>
            <button type="button" tabIndex={-1} aria-label={t("more", label)} onClick={() => by(1)}>
              +
            </button>
          </span>
        )}
      </span>
      {typed.wrong && <WrongNumber text={typed.wrong} />}
    </div>
  );
}

/**
 * A number that is typed. It counts on Enter or on leaving; until then, and as long as it is none, the
 * field keeps what stands in it, whatever comes from the server meanwhile.
 */
export function useTyped(shown: string, onChange: (x: number | null) => void, { bounded = (x: number) => x, mayBeEmpty = false } = {}) {
  const [text, setText] = useState(shown);
  const [wrong, setWrong] = useState("");
  /** Before the next picture: two quick presses count both. */
  const now = useRef({ text: shown, told: shown, typing: false });
  const put = (next: string) => setText((now.current.text = next));
  useEffect(() => {
    now.current.told = shown;
    if (!now.current.typing) put(shown);
  }, [shown]);
  const tell = (next: string, x: number | null) => {
    now.current.typing = false;
    setWrong("");
    put(next);
    if (next === now.current.told) return;
    now.current.told = next;
    onChange(x);
  };
  const keep = (x: number) => tell(typedAs(bounded(x)), bounded(x));
  const commit = () => {
    if (!now.current.typing) return;
    const found = numberIn(now.current.text);
    if (found !== null) keep(found);
    else if (now.current.text.trim() === "") tell(mayBeEmpty ? "" : now.current.told, null);
    else setWrong(now.current.text.trim());
  };
  const input = {
    "value": text,
    "aria-invalid": wrong !== "" || undefined,
    "onInput": (event: { currentTarget: HTMLInputElement }) => {
      now.current.typing = true;
      put(event.currentTarget.value);
    },
    "onBlur": commit,
  };
  return { input, wrong, commit, keep, now: () => now.current.text };
}

export function WrongNumber({ text }: { text: string }) {
  return (
    <p class="wrong" role="alert">
      {t("wrong.number", text)}
    </p>
  );
}

export function Switch({ on, label, onChange }: { on: boolean; label: string; onChange: (on: boolean) => void }) {
  return <button type="button" class={`sw ${on ? "" : "n"}`} role="switch" aria-checked={on} aria-label={label} onClick={() => onChange(!on)} />;
}

/** What went wrong, in place: what, why, what to do. */
export function Notice({
  tone,
  title,
  children,
  action,
}: {
  tone: "red" | "amber" | "plain";
  title: string;
  children?: ComponentChildren;
  action?: ComponentChildren;
}) {
  return (
    <div class={`notice ${tone}`} role={tone === "red" ? "alert" : "status"}>
      <Icon name={tone === "red" ? "stop" : tone === "amber" ? "warn" : "help"} />
      <div>
        <b>{title}</b>
        {children && <div class="soft">{children}</div>}
        {action && <div class="acts">{action}</div>}
      </div>
    </div>
  );
}

/** A question in place of a dialog: it stands where the act was asked for, and Esc takes it back. */
export function Confirm({
  title,
  children,
  yes,
  onYes,
  onNo,
  danger,
}: {
  title: string;
  children?: ComponentChildren;
  yes: string;
  onYes: () => void;
  onNo: () => void;
  danger?: boolean;
}) {
  const first = useRef<HTMLDivElement>(null);
  useEffect(() => first.current?.focus(), []);
  return (
    <div
      class="confirm"
      role="group"
      aria-label={title}
      tabIndex={-1}
      ref={first}
      onKeyDown={(event) => {
        if (event.key === "Escape") onNo();
      }}
    >
      <b>{title}</b>
      {children}
      <div class="acts">
        <Button danger={danger} go={!danger} onClick={onYes}>
          {yes}
        </Button>
        <Button onClick={onNo}>{t("keep")}</Button>
      </div>
    </div>
  );
}

export function Empty({ icon, title, children }: { icon: IconName; title: string; children?: ComponentChildren }) {
  return (
    <div class="empty">
      <Icon name={icon} />
      <h2>{title}</h2>
      {children}
    </div>
  );
}
