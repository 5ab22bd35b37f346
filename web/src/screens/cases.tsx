/** Cases: which limb, what next. The list, the new case, the archive, the disk. */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";

import { type Schemas, api, taken } from "../api/client";
import { listen } from "../api/events";
import { Icon } from "../design/icons";
import { Button, Chip, Confirm, Empty, Notice, SideBadge } from "../design/parts";
import { Refusal, parted } from "../design/refusal";
import { kindName, limbKinds } from "../limb-kinds";
import { newOffer, perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { bytes, t, tOr, when } from "../texts";
import { type Finding, isFinding, sentence, told } from "../words";

type Case = Schemas["Case"];
type Filter = "all" | "work" | "sent" | "archive";

const FILTERS: readonly Filter[] = ["all", "work", "sent", "archive"];

export function CasesScreen() {
  const asked = useAsked(() => taken(api.GET("/api/v1/cases", {})), []);
  const filter = useSignal<Filter>("all");
  const find = useSignal("");
  const making = useSignal(false);
  const clearing = useSignal(false);
  const act = useAct();
  useEffect(() => listen("/events", () => void asked.again()), []);

  const list = asked.value.value;
  const all = list?.cases ?? [];
  const sent = (one: Case) => one.steps.some((step) => step.name === "send" && step.state === "done");
  const members: Record<Filter, Case[]> = {
    all: all.filter((one) => !one.archived),
    work: all.filter((one) => !one.archived && !sent(one)),
    sent: all.filter((one) => !one.archived && sent(one)),
    archive: all.filter((one) => one.archived),
  };
  const wanted = find.value.trim().toLowerCase();
  const shown = members[filter.value].filter((one) => `${one.id} ${one.note}`.toLowerCase().includes(wanted));

  const sample = () =>
    act.run(async () => {
      const made = await perform("", "post", "/api/v1/cases/sample", {});
      go(href.step(made.id, "capture"));
    });
  const clearAll = () =>
    act.run(async () => {
      clearing.value = false;
      for (const one of all.filter((case_) => case_.state !== "computing" && case_.state !== "held"))
        await perform(one.id, "post", "/api/v1/cases/{case_id}/clear", { params: { path: { case_id: one.id } } });
      await asked.again();
    });

  return (
    <main class="cases" id="content" tabIndex={-1}>
      <div class="head">
        <h1>{t("cases")}</h1>
        <div class="filters" role="radiogroup" aria-label={t("cases")}>
          {FILTERS.map((one) => (
            <button key={one} type="button" role="radio" aria-checked={filter.value === one} class={filter.value === one ? "on" : ""} onClick={() => (filter.value = one)}>
              {t(`cases.${one}`, members[one].length)}
            </button>
          ))}
        </div>
        <span class="grow" />
        <label class="field find">
          <Icon name="find" />
          <span class="unseen">{t("cases.find")}</span>
          <input type="search" placeholder={t("cases.find")} value={find.value} onInput={(event) => (find.value = event.currentTarget.value)} />
        </label>
        <Button go icon="plus" onClick={() => (making.value = !making.value)}>
          {t("cases.new")}
        </Button>
      </div>
      {making.value && <NewCase onClose={() => (making.value = false)} />}
      <Refusal refused={asked.refused.value ?? act.refused.value} action={<Button onClick={() => void asked.again()}>{t("again")}</Button>} />
      {act.busy.value && !making.value && <Notice tone="plain" title={t("cases.sample.making")} />}
      {list && all.length === 0 && !making.value && (
        <Empty icon="limb" title={t("cases.empty")}>
          <p>{t("cases.empty.how")}</p>
          <div class="acts">
            <Button icon="plus" onClick={() => (making.value = true)}>
              {t("cases.new")}
            </Button>
            <Button off={act.busy.value && t("cases.sample.making")} onClick={() => void sample()}>
              {t("cases.sample")}
            </Button>
          </div>
        </Empty>
      )}
      {list && all.length > 0 && shown.length === 0 && (
        <Empty icon="find" title={wanted ? t("cases.none", find.value) : t("cases.none.here")}>
          <div class="acts">
            <Button
              onClick={() => {
                find.value = "";
                filter.value = "all";
              }}
            >
              {t("cases.all.show")}
            </Button>
          </div>
        </Empty>
      )}
      {shown.length > 0 && (
        <div class="list">
          <table>
            <thead>
              <tr>
                <th>
                  <span class="unseen">{t("cases.th.picture")}</span>
                </th>
                <th>{t("cases.th.case")}</th>
                <th>{t("cases.th.side")}</th>
                <th class="wide-only">{t("cases.th.change")}</th>
                <th>{t("cases.th.state")}</th>
                <th class="step-h wide-only">{t("cases.th.steps")}</th>
                <th>{t("cases.th.next")}</th>
                <th class="num wide-only">{t("cases.th.disk")}</th>
                <th>
                  <span class="unseen">{t("cases.th.more")}</span>
                </th>
              </tr>
            </thead>
            <tbody>
              {shown.map((one) => (
                <Row key={one.id} one={one} onChange={() => void asked.again()} />
              ))}
            </tbody>
          </table>
        </div>
      )}
      {list && all.length > 0 && (
        <>
          <div class="foot">
            <Icon name="disk" />
            <span>{t("cases.disk", bytes(list.bytes), all.length, bytes(list.free_bytes))}</span>
            <DiskBar used={list.bytes} clearable={list.clearable_bytes} free={list.free_bytes} />
            {list.clearable_bytes > 0 && (
              <>
                <span>{t("cases.clearable", bytes(list.clearable_bytes))}</span>
                <button type="button" class="linkish" aria-expanded={clearing.value} onClick={() => (clearing.value = !clearing.value)}>
                  {t("cases.see")}
                </button>
              </>
            )}
            <span class="grow" />
            {!all.some((one) => one.sample) && (
              <button type="button" class="linkish" onClick={() => void sample()}>
                {t("cases.sample")}
              </button>
            )}
          </div>
          {clearing.value && (
            <Confirm title={t("cases.clear.sure")} yes={t("cases.clear")} onYes={() => void clearAll()} onNo={() => (clearing.value = false)}>
              <p>{t("cases.clear.goes", bytes(list.clearable_bytes))}</p>
            </Confirm>
          )}
        </>
      )}
    </main>
  );
}

function DiskBar({ used, clearable, free }: { used: number; clearable: number; free: number }) {
  const all = used + free || 1;
  return (
    <svg class="du" viewBox="0 0 220 8" width="220" height="8" aria-hidden="true">
      <rect class="free" width="220" height="8" />
      <rect class="kept" width={Math.max(2, (220 * (used - clearable)) / all)} height="8" />
      <rect class="clear" x={Math.max(2, (220 * (used - clearable)) / all)} width={(220 * clearable) / all} height="8" />
    </svg>
  );
}

/** What a case says of itself in the list: a chip and one line. */
export function StateOf({ one }: { one: Case }) {
  if (one.state === "finished" && one.verdict)
    return (
      <>
        <Chip tone={one.verdict.light}>{t(`verdict.${one.verdict.light}`)}</Chip>
        <div class="small soft nt" title={told(one.verdict.headline)}>
          {inShort(one.verdict)}
        </div>
      </>
    );
  if (one.state === "refused" || one.state === "failed")
    return (
      <>
        <Chip tone="red">{t("case.state.refused")}</Chip>
        <div class="small soft nt">{one.finding && parted(told(one.finding))[0]}</div>
      </>
    );
  return (
    <>
      <Chip tone="plain">{tOr(`case.state.${one.state}`, one.state)}</Chip>
      <div class="small soft nt">{one.finding ? told(one.finding) : one.photos ? t("state.photos", one.photos) : ""}</div>
    </>
  );
}

/** A verdict without its colour, which the chip beside it shows; a file of an earlier version has it in one sentence. */
export function withoutColour(headline: Finding): Finding {
  const said = headline.values.verdict;
  return isFinding(said) ? said : headline;
}

/** The same in one line of the list: what the surface keeps to, or the first doubt; and whether anything checked the size. */
export function inShort({ headline, size_checked }: { headline: Finding; size_checked: boolean }): string {
  const verdict = withoutColour(headline);
  const { p95_mm, first } = verdict.values;
  const said =
    verdict.code === "verdict.green" && typeof p95_mm === "number"
      ? t("case.within", p95_mm.toFixed(2))
      : isFinding(first) && verdict.code === "verdict.doubtful"
        ? sentence(first)
        : sentence(verdict);
  return size_checked || headline.gravity === "fault" ? inBrief(said) : `${inBrief(said)}; ${t("case.size.unchecked")}`;
}

/** A sentence as far as its first stop. */
const inBrief = (said: string) => parted(said)[0].split(/[:;]|\.$/)[0];

function nextOf(one: Case): { text: string; to: string } {
  const to = (step: Case["next"]) => href.step(one.id, step);
  if (one.state === "computing" || one.state === "held") return { text: t("next.watch"), to: to("result") };
  if (one.state === "refused" || one.state === "failed" || one.state === "interrupted") return { text: t("next.todo"), to: to("result") };
  if (one.state === "empty" || one.state === "photos" || one.state === "cancelled") return { text: t("next.capture"), to: to("capture") };
  if (one.verdict && one.verdict.light !== "green" && one.next === "align") return { text: t("next.todo"), to: to("result") };
  if (one.next === "record") return { text: t("next.record"), to: to("record") };
  return { text: t("next.go", t(`step.${one.next}`)), to: to(one.next) };
}

function Row({ one, onChange }: { one: Case; onChange: () => void }) {
  const next = nextOf(one);
  const open = useSignal(false);
  const doing = useSignal<"delete" | "rename" | "clear" | null>(null);
  const act = useAct();
  const held = useSignal<Schemas["Held"][]>([]);
  const path = { params: { path: { case_id: one.id } } };
  const change = (body: Schemas["CaseChange"]) =>
    act.run(async () => {
      await perform(one.id, "patch", "/api/v1/cases/{case_id}", { ...path, body });
      open.value = false;
      doing.value = null;
      onChange();
    });
  const ask = (what: "delete" | "clear") =>
    act.run(async () => {
      held.value = await taken(api.GET("/api/v1/cases/{case_id}/contents", path));
      open.value = false;
      doing.value = what;
    });
  const remove = () =>
    act.run(async () => {
      await perform(one.id, "delete", "/api/v1/cases/{case_id}", path);
      onChange();
    });
  const clear = () =>
    act.run(async () => {
      await perform(one.id, "post", "/api/v1/cases/{case_id}/clear", path);
      doing.value = null;
      onChange();
    });
  const goes = (what?: string) => held.value.filter((part) => !what || part.what === what);
  const sum = (what?: string) => goes(what).reduce((all, part) => all + part.bytes, 0);
  const here = one.steps.findIndex((step) => step.name === one.next);
  return (
    <>
      <tr>
        <td class="th">
          {one.thumbnail ? (
            <img class="thumb" src={one.thumbnail} alt="" loading="lazy" width="56" height="56" />
          ) : (
            <span class="thumb none">
              <Icon name={one.state === "photos" ? "camera" : "limb"} />
            </span>
          )}
        </td>
        <td>
          <a class="case-link" href={next.to}>
            {one.id}
          </a>
          <br />
          <span class="faint small">{one.sample ? t("kind.sample") : [kindName(one.kind), one.note].filter(Boolean).join(" · ")}</span>
        </td>
        <td>
          <SideBadge side={one.side} />
        </td>
        <td class="wide-only">
          <span class="soft">{when(one.changed)}</span>
        </td>
        <td>
          <StateOf one={one} />
        </td>
        <td class="wide-only">
          <div class="dots" role="img" aria-label={t("cases.step.of", here + 1, t(`step.${one.next}`))}>
            {one.steps.map((step, i) => (
              <i key={step.name} class={step.state === "done" ? "d" : i === here ? "h" : ""} />
            ))}
          </div>
        </td>
        <td>
          <a class="btn next-btn" href={next.to}>
            {next.text}
          </a>
        </td>
        <td class="num wide-only">
          <span class="soft">{bytes(one.bytes)}</span>
        </td>
        <td>
          <div class="more">
            <Button bare icon="more" class="icon-only" label={`${t("cases.th.more")}: ${one.id}`} pressed={open.value} onClick={() => (open.value = !open.value)} />
            {open.value && (
              <Menu onClose={() => (open.value = false)}>
                <button type="button" onClick={() => ((doing.value = "rename"), (open.value = false))}>
                  {t("cases.rename")}
                </button>
                <button type="button" onClick={() => void change({ archived: !one.archived })}>
                  {t(one.archived ? "cases.from.archive" : "cases.to.archive")}
                </button>
                <button type="button" onClick={() => void ask("clear")}>
                  {t("cases.clear.sure").replace(/\?$/, "")}
                </button>
                <button type="button" class="danger" onClick={() => void ask("delete")}>
                  {t("cases.delete")}
                </button>
              </Menu>
            )}
          </div>
        </td>
      </tr>
      {(doing.value || act.refused.value) && (
        <tr>
          <td colSpan={9} class="below">
            <Refusal refused={act.refused.value} />
            {doing.value === "delete" && (
              <Confirm danger title={t("cases.delete.sure", one.id)} yes={t("cases.delete")} onYes={() => void remove()} onNo={() => (doing.value = null)}>
                <p>{t("cases.delete.goes", goes().reduce((n, part) => n + part.files, 0), bytes(sum()))}</p>
                <ul class="held">
                  {goes().map((part) => (
                    <li key={part.what}>
                      {tOr(`held.${part.what}`, part.what)}: {part.files}, {bytes(part.bytes)}
                    </li>
                  ))}
                </ul>
              </Confirm>
            )}
            {doing.value === "clear" && (
              <Confirm title={t("cases.clear.sure")} yes={t("cases.clear")} onYes={() => void clear()} onNo={() => (doing.value = null)}>
                <p>{t("cases.clear.goes", bytes(sum("intermediate products")))}</p>
              </Confirm>
            )}
            {doing.value === "rename" && <Rename one={one} onKeep={(body) => void change(body)} onClose={() => (doing.value = null)} />}
          </td>
        </tr>
      )}
    </>
  );
}

function Menu({ children, onClose }: { children: preact.ComponentChildren; onClose: () => void }) {
  const menu = useRef<HTMLDivElement>(null);
  useEffect(() => {
    menu.current?.querySelector("button")?.focus();
    const away = (event: PointerEvent) => {
      if (!menu.current?.parentElement?.contains(event.target as Node)) onClose();
    };
    addEventListener("pointerdown", away);
    return () => removeEventListener("pointerdown", away);
  }, []);
  return (
    <div class="menu" ref={menu} onKeyDown={(event) => event.key === "Escape" && onClose()}>
      {children}
    </div>
  );
}

function Rename({ one, onKeep, onClose }: { one: Case; onKeep: (body: Schemas["CaseChange"]) => void; onClose: () => void }) {
  /** As the form was opened: what is not changed here may be changed elsewhere meanwhile. */
  const before = useMemo(() => ({ note: one.note, side: one.side ?? null, kind: one.kind ?? null }), []);
  const note = useSignal(one.note);
  const side = useSignal(one.side ?? null);
  const kind = useSignal(one.kind ?? null);
  return (
    <div class="confirm" onKeyDown={(event) => event.key === "Escape" && onClose()}>
      <CaseFields note={note} side={side} kind={kind} />
      <div class="acts">
        <Button go onClick={() => onKeep({ ...(note.value !== before.note && { note: note.value }), ...(side.value !== before.side && { side: side.value }), ...(kind.value !== before.kind && { kind: kind.value }) })}>
          {t("save")}
        </Button>
        <Button onClick={onClose}>{t("cancel")}</Button>
      </div>
    </div>
  );
}

function CaseFields({
  note,
  side,
  kind,
}: {
  note: { value: string };
  side: { value: Case["side"] | null };
  kind: { value: Case["kind"] | null };
}) {
  return (
    <div class="case-fields">
      <fieldset>
        <legend>{t("cases.which.side")}</legend>
        <div class="choices">
          {(["right", "left"] as const).map((one) => (
            <label key={one} class={`choice ${side.value === one ? "on" : ""}`}>
              <input type="radio" name="side" checked={side.value === one} onChange={() => (side.value = one)} />
              <SideBadge side={one} />
            </label>
          ))}
        </div>
      </fieldset>
      <fieldset>
        <legend>{t("cases.which.kind")}</legend>
        <div class="choices">
          {limbKinds.value.map((one) => (
            <label key={one.kind} class={`choice ${kind.value === one.kind ? "on" : ""}`}>
              <input type="radio" name="kind" checked={kind.value === one.kind} onChange={() => (kind.value = one.kind)} />
              {kindName(one.kind)}
            </label>
          ))}
        </div>
      </fieldset>
      <label class="stacked">
        <span>{t("cases.name")}</span>
        <span class="field">
          <input maxLength={200} value={note.value} onInput={(event) => (note.value = event.currentTarget.value)} />
        </span>
        <span class="small faint">{t("cases.no.name")}</span>
      </label>
    </div>
  );
}

function NewCase({ onClose }: { onClose: () => void }) {
  const note = useSignal("");
  const side = useSignal<Case["side"] | null>(null);
  const kind = useSignal<Case["kind"] | null>(null);
  const act = useAct();
  const offer = useMemo(newOffer, []);
  const make = () =>
    act.run(async () => {
      const body = { note: note.value, side: side.value, kind: kind.value };
      const made = await perform("", "post", "/api/v1/cases", { body }, { id: offer.idOf(body) });
      if (act.screen.open) go(href.step(made.id, "capture"));
    });
  const lacks = act.busy.value ? t("cases.making") : !side.value ? t("cases.which.side") : !kind.value ? t("cases.which.kind") : null;
  return (
    <section class="card" aria-label={t("cases.new")} onKeyDown={(event) => event.key === "Escape" && onClose()}>
      <h2>{t("cases.new")}</h2>
      <div inert={act.busy.value}>
        <CaseFields note={note} side={side} kind={kind} />
      </div>
      <Refusal refused={act.refused.value} />
      <div class="acts">
        <Button go off={lacks} onClick={() => void make()}>
          {t("cases.make")}
        </Button>
        <Button onClick={onClose}>{t("cancel")}</Button>
      </div>
    </section>
  );
}
