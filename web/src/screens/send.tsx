/**
 * Send: right side, right file? The file is written and read back by the server; two checks are made
 * by a person: the side, asked without a guess, and the picture against the patient.
 */
import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useId, useRef } from "preact/hooks";

import { ROOT, type Schemas, api, taken } from "../api/client";
import { Icon } from "../design/icons";
import { Button, Chip, Notice, NumberField } from "../design/parts";
import { Refusal } from "../design/refusal";
import { type ExportKind, exportKinds, fieldOf, fileName, limitsOf, usedFor, usualOf } from "../formats";
import { signed } from "../geometry/scales";
import { sided } from "../limb-kinds";
import { perform } from "../state/acts";
import { useAct, useAsked } from "../state/asked";
import { go, href } from "../state/route";
import { expert } from "../state/settings";
import { bytes, t, when } from "../texts";
import { type Finding, told } from "../words";
import { openWith } from "./rectify";
import type { RoomProps } from "./room";

type Side = "left" | "right";

/** What a person is asked of a kind of file; its unit, its limits and what it is usually, the server says. */
const ASKED: Readonly<Record<string, readonly Asked[]>> = {
  aop: [
    { name: "spokes", label: "send.spokes", step: 10, decimals: 0 },
    { name: "spacing_mm", label: "send.spacing", step: 0.5, decimals: 2 },
    { name: "distal_slices", label: "send.distal", step: 2, decimals: 0 },
  ],
  dxf: [{ name: "spacing_mm", label: "send.sections", step: 5, decimals: 1 }],
  gcode: [{ name: "tool_diameter_mm", label: "send.tool", step: 1, decimals: 1 }],
};

interface Asked {
  readonly name: string;
  readonly label: Parameters<typeof t>[0];
  readonly step: number;
  readonly decimals: number;
}

export function SendScreen({ room }: RoomProps) {
  const path = { params: { path: { case_id: room.id } } };
  const kind = useSignal("aop");
  const side = useSignal<Side | null>(null);
  const held = useSignal(false);
  const signer = useSignal("");
  const more = useSignal(false);
  /** Whether the fields of an AOP file's grid are open. */
  const grid = useSignal(false);
  /** What was entered, by kind of file and field; the rest is as usual. */
  const entered = useSignal<Readonly<Record<string, Record<string, number>>>>({});
  const written = useSignal<Schemas["ExportedFile"] | null>(null);
  const act = useAct();
  /** The file that is asked for now, and no other, is shown and saved. */
  const wanted = useRef<Schemas["NewExport"] | null>(null);
  const ledger = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/recipe/ledger", path)), [room.id, room.news.work]);
  const before = useAsked(() => taken(api.GET("/api/v1/cases/{case_id}/exports", path)), [room.id, room.news.work]);
  const known = room.info.side;
  const red = room.info.verdict?.light === "red";
  const other = side.value !== null && (known === "left" || known === "right") && known !== side.value;
  const torso = !sided(room.info.kind);

  const write = (next: { kind?: string; side?: Side | null } = {}) => {
    const chosen = { kind: next.kind ?? kind.value, side: next.side === undefined ? side.value : next.side };
    kind.value = chosen.kind;
    side.value = chosen.side;
    held.value = false;
    written.value = null;
    wanted.current = null;
    const contradicts = chosen.side !== null && (known === "left" || known === "right") && known !== chosen.side;
    if ((!chosen.side && !torso) || contradicts || (red && !signer.value.trim())) return;
    wanted.current = {
      kind: chosen.kind,
      side: torso ? "none" : (chosen.side as Side),
      signed_by: signer.value.trim(),
      how: howOf(chosen.kind),
    };
    if (!act.busy.value) void act.run(writeWanted).then(() => before.again());
  };
  /** What the receiver expects of a kind, as it stands in its fields. */
  const howOf = (one: string): NonNullable<Schemas["NewExport"]["how"]> => Object.fromEntries((ASKED[one] ?? []).map(({ name }) => [name, valueOf(one, name)]));
  const valueOf = (one: string, name: string): number | undefined => entered.value[one]?.[name] ?? usualOf(one, name);
  const enter = (one: string, name: string, value: number) => {
    entered.value = { ...entered.value, [one]: { ...entered.value[one], [name]: value } };
    write();
  };
  /** One file after the other; what was wanted before and is not any more is not shown. */
  const writeWanted = async () => {
    for (let body = wanted.current; body;) {
      const made = await perform(room.id, "post", "/api/v1/cases/{case_id}/exports", { ...path, body }, { lane: `${room.id} files` }).catch(
        (error: unknown) => {
          if (wanted.current === body) throw error;
          return null; // refused, and not wanted any more
        },
      );
      if (wanted.current === body) {
        written.value = made;
        break;
      }
      body = wanted.current;
    }
  };
  const w = written.value;
  const off = act.busy.value
    ? t("send.writing")
    : !side.value && !torso
      ? t("send.off.side")
      : other
        ? t("send.off.contradiction")
        : red && !signer.value.trim()
          ? t("send.off.red")
          : !w
            ? t("send.off.none")
            : !held.value
              ? t("send.off.picture")
              : null;
  const kinds = exportKinds.value;
  const shown = kinds.find((one) => one.kind === kind.value);
  const all = more.value || shown?.everyday === false;
  const option = (one: ExportKind) => (
    <label key={one.kind} class={`opt ${one === shown ? "on" : ""}`}>
      <input type="radio" name="kind" checked={one === shown} onChange={() => write({ kind: one.kind })} />
      <b>{fileName(one.kind)}</b>
      <small>{usedFor(one)}</small>
    </label>
  );
  return (
    <div class="work">
      <main class="send-main" id="content" tabIndex={-1}>
        <div>
          <h1>{t("send.title")}</h1>
          <p class="soft">{t("send.how")}</p>
        </div>
        <Card step={1} done title={t("send.what")}>
          <div class="opts">{kinds.filter((one) => one.everyday).map(option)}</div>
          {all && <div class="opts">{kinds.filter((one) => !one.everyday).map(option)}</div>}
          <p class="opt-links">
            {!all && (
              <button type="button" class="linkish" onClick={() => (more.value = true)}>
                {t("send.more")}
              </button>
            )}
            {shown?.kind === "aop" && !grid.value && (
              <span class="soft small-note">
                {t("send.grid", valueOf("aop", "spokes") ?? "", valueOf("aop", "spacing_mm") ?? "")}{" "}
                <button type="button" class="linkish" onClick={() => (grid.value = true)}>
                  {t("send.grid.change")}
                </button>
              </span>
            )}
          </p>
          {ASKED[kind.value] && (kind.value !== "aop" || grid.value) && (
            <div class="own-board">
              {ASKED[kind.value]?.map(({ name, label, step, decimals }) => (
                <NumberField
                  key={kind.value + name}
                  label={t(label)}
                  unit={fieldOf(kind.value, name)?.unit ?? ""}
                  step={step}
                  decimals={decimals}
                  {...limitsOf(kind.value, name)}
                  value={valueOf(kind.value, name) ?? null}
                  onChange={(value) => enter(kind.value, name, value)}
                />
              ))}
            </div>
          )}
        </Card>
        {!torso && (
          <Card step={2} done={side.value !== null && !other} title={t("send.side")} aside={t("send.side.look")}>
            <div class="gate" role="radiogroup" aria-label={t("send.side")}>
              {(["right", "left"] as const).map((one) => (
                <button
                  key={one}
                  type="button"
                  role="radio"
                  aria-checked={side.value === one}
                  class={`lr ${one} ${side.value === one ? "on" : ""}`}
                  onClick={() => write({ side: one })}
                >
                  <b aria-hidden="true">{t(one === "left" ? "side.L" : "side.R")}</b>
                  <span>
                    {t(`side.${one}`)}
                    {side.value === one && <small>{known === one ? t("send.agrees") : known ? t("send.contradicts") : ""}</small>}
                  </span>
                  {side.value === one && <Icon name={other ? "warn" : "tick"} />}
                </button>
              ))}
            </div>
            {other && (
              <Notice tone="red" title={t("send.contradiction")}>
                {t("send.contradiction.do")}
              </Notice>
            )}
          </Card>
        )}
        {red && (
          <Card step={2} done={signer.value.trim() !== ""} title={t("send.red")} aside={t("send.red.why")}>
            <span class="field wide">
              <input
                aria-label={t("send.red.who")}
                placeholder={t("send.red.who")}
                maxLength={300}
                value={signer.value}
                onInput={(event) => (signer.value = event.currentTarget.value)}
                onChange={() => write()}
              />
            </span>
          </Card>
        )}
        <Card step={3} done={held.value} title={t("send.picture")} aside={t("send.picture.from")}>
          {act.busy.value && (
            <p class="soft" role="status">
              {t("send.writing")}
            </p>
          )}
          <Refusal refused={act.refused.value} />
          {shown?.mesh && ledger.value.value?.solid === false && (
            <Notice
              tone="amber"
              title={t("send.shell")}
              action={
                <Button
                  onClick={() => {
                    openWith.value = "wall";
                    go(href.step(room.id, "rectify"));
                  }}
                >
                  {t("send.shell.wall")}
                </Button>
              }
            >
              {t("send.shell.why")}
            </Notice>
          )}
          {w ? (
            <>
              <img
                class="mirror"
                src={`${ROOT}/cases/${room.id}/exports/${encodeURIComponent(w.name)}/mirror?${w.sha256.slice(0, 8)}`}
                alt={t("send.picture.alt", w.side === "left" ? t("side.LEFT") : w.side === "right" ? t("side.RIGHT") : "")}
              />
              <label class={`tick ${held.value ? "on" : ""}`}>
                <input type="checkbox" checked={held.value} onChange={(event) => (held.value = event.currentTarget.checked)} />
                {t("send.picture.tick")}
              </label>
            </>
          ) : (
            !act.busy.value && <p class="soft">{t("send.picture.later")}</p>
          )}
        </Card>
      </main>
      <aside class="pane" aria-label={t("send.file")}>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <section>
            <h3>{t("send.file")}</h3>
            <p class="file-name">{w?.name ?? "–"}</p>
            <p class="small faint">{w ? `${bytes(w.bytes)}, ${w.unit}. ${t("send.noname")}` : t("send.file.later")}</p>
          </section>
          {w && (
            <section>
              <div class="row-head">
                <h2>{t("send.readback")}</h2>
                <span class="grow" />
                <Chip tone={w.doubt ? "amber" : "green"}>{t("send.agrees.chip")}</Chip>
              </div>
              <table class="kv">
                <tbody>
                  <Fact name={t("send.fact.side")} value={w.side === "left" ? t("side.LEFT") : w.side === "right" ? t("side.RIGHT") : "–"} />
                  <Fact name={t("send.fact.unit")} value={w.unit} />
                  {known_(w.surface_within_mm) && <Fact name={t("send.fact.surface")} value={t("send.within", (w.surface_within_mm ?? 0).toFixed(2))} />}
                  {known_(w.girth_change_mm) && <Fact name={t("send.fact.girths")} value={t("send.most", signed(w.girth_change_mm ?? 0, 2))} />}
                  {known_(w.volume_change) && <Fact name={t("volume")} value={`${signed(100 * (w.volume_change ?? 0), 2)} %`} />}
                  {known_(w.minutes) && <Fact name={t("send.fact.minutes")} value={`${(w.minutes ?? 0).toFixed(0)} min`} />}
                  <Fact name={t("recipe")} value={t("state.edits", w.recipe_edits)} />
                </tbody>
              </table>
              <ul class="findings small-note soft">
                {(w.said ?? []).map((one) => (
                  <li key={one.code}>{told(one as Finding)}</li>
                ))}
              </ul>
              {expert.value && <p class="mono">sha256 {w.sha256}</p>}
            </section>
          )}
          {(w?.notes ?? []).map((one) => (
            <section key={one.code}>
              <Notice tone="amber" title={told(one as Finding)} />
            </section>
          ))}
          {w?.doubt && (
            <section>
              <Notice tone="red" title={told(w.doubt as Finding)} />
            </section>
          )}
          <section>
            <h2>{t("send.before")}</h2>
            <p class="soft small-note">{t("send.before.how")}</p>
          </section>
          {(before.value.value ?? []).length > 0 && (
            <section>
              <h3>{t("send.earlier")}</h3>
              <ul class="earlier">
                {(before.value.value ?? []).slice(0, 8).map((one) => (
                  <li key={one.name + one.made}>
                    <span>{one.name}</span>
                    <span class="faint small">{when(one.made)}</span>
                    <span class="faint small made-of">{madeOf(one)}</span>
                  </li>
                ))}
              </ul>
            </section>
          )}
        </div>
        <div class="next">
          {off || !w ? (
            <Button go big off={off ?? t("send.off.none")}>
              {t("send.save")}
            </Button>
          ) : (
            <a class="btn go big" id="save-file" href={`${ROOT}/cases/${room.id}/exports/${encodeURIComponent(w.name)}`} download={w.name}>
              {t("send.save")}
            </a>
          )}
          <p class="small soft">
            {off ?? (
              <button type="button" class="linkish" onClick={() => go(href.step(room.id, "record"))}>
                {t("send.next")}
              </button>
            )}
          </p>
        </div>
      </aside>
    </div>
  );
}

/** What tells a file from another of the same limb: its side, its edits, who signed for it, and which scan and recipe are in it. */
export function madeOf(one: Pick<Schemas["ExportedFile"], "side" | "recipe_edits" | "signed_by" | "scan_sha256" | "recipe_sha256">): string {
  const short = (sha256: string) => sha256.slice(0, 8);
  return [
    one.side === "none" ? "" : t(one.side === "left" ? "side.LEFT" : "side.RIGHT"),
    t("state.edits", one.recipe_edits),
    one.signed_by && t("send.signed", one.signed_by),
    t("send.of.scan", short(one.scan_sha256)),
    one.recipe_sha256 && t("send.of.recipe", short(one.recipe_sha256)),
  ]
    .filter(Boolean)
    .join(" · ");
}

const known_ = (value: number | null | undefined): boolean => value !== null && value !== undefined;

function Fact({ name, value }: { name: string; value: string }) {
  return (
    <tr>
      <td>{name}</td>
      <td>
        <span class="g ok-mark">
          <Icon name="ok" small />
        </span>
        {value}
      </td>
    </tr>
  );
}

function Card({ step, done, title, aside, children }: { step: number; done: boolean; title: string; aside?: string; children: ComponentChildren }) {
  const id = useId();
  return (
    <section class="card gate-card" aria-labelledby={id}>
      <header>
        <span class={`n ${done ? "ok" : "on"}`}>{done ? <Icon name="tick" small /> : step}</span>
        <h2 id={id}>{title}</h2>
        {aside && <span class="soft">{aside}</span>}
      </header>
      {children}
    </section>
  );
}
