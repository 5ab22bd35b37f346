/** The frame round every screen: top bar, column of steps or of places, content. */
import type { ComponentChildren } from "preact";

import { type Page, type Place, STEPS, type Step, href } from "../state/route";
import { person } from "../state/person";
import { expert, setExpert } from "../state/settings";
import { t } from "../texts";
import { WhoIsHere } from "../screens/gate";
import { Icon, type IconName } from "./icons";
import { type Side, SideBadge } from "./parts";

export interface StepState {
  readonly state: "done" | "on" | "open" | "later";
  /** One line of how it stands. */
  readonly note: string;
  /** Which step has to come before it, in words; empty where it can be opened. */
  readonly needs: string;
  readonly warn?: boolean;
}

export interface CaseHead {
  readonly id: string;
  readonly kind: string;
  readonly side: Side;
  readonly steps: Record<Step, StepState>;
}

export function Shell({
  place,
  head,
  children,
  onHelp,
  helping,
}: {
  place: Place;
  head: CaseHead | null;
  children: ComponentChildren;
  onHelp: () => void;
  helping: boolean;
}) {
  return (
    <div class="app">
      <a
        class="skip"
        href="#content"
        onClick={(event) => {
          event.preventDefault();
          document.getElementById("content")?.focus();
        }}
      >
        {t("skip")}
      </a>
      <header class="top">
        <a class="brand" href={href.cases} aria-label="limbgram">
          <Icon name="limb" />
          <span>limbgram</span>
        </a>
        {head && (
          <>
            <a class="crumb hide-small" href={href.cases}>
              {t("cases")}
            </a>
            <span class="faint hide-small" aria-hidden="true">
              /
            </span>
            <span class="case">{head.id}</span>
            <span class="soft kind">{head.kind}</span>
            <SideBadge side={head.side} />
            <span class="unit hide-small" title={t("unit")}>
              mm
            </span>
          </>
        )}
        <span class="grow" />
        <span class="quiet where">
          <Icon name="lock" small />
          {t(person.value?.network ? "local.clinic" : "local")}
        </span>
        <WhoIsHere />
        <button type="button" class="btn bare quiet-btn" aria-label={t("help")} aria-expanded={helping} onClick={onHelp}>
          <Icon name="help" />
          <span>{t("help")}</span>
        </button>
        <button
          type="button"
          class={`btn bare quiet-btn hide-small ${expert.value ? "chosen" : ""}`}
          aria-pressed={expert.value}
          onClick={() => setExpert(!expert.value)}
        >
          <span class="always">{t("expert")}</span>
        </button>
      </header>
      {head && place.at === "case" ? <StepRail id={place.id} here={place.step} steps={head.steps} /> : <NavRail here={place.at} />}
      {children}
    </div>
  );
}

function StepRail({ id, here, steps }: { id: string; here: Page; steps: Record<Step, StepState> }) {
  return (
    <nav class="rail" aria-label={t("steps")}>
      {STEPS.map((step, i) => {
        const { state, note, needs, warn } = steps[step];
        const on = step === here;
        const inside = (
          <>
            <span class="n">{state === "done" && !on ? <Icon name="tick" small /> : i + 1}</span>
            {t(`step.${step}`)}
            <small>{note}</small>
          </>
        );
        const look = `step ${on ? "on" : state === "done" ? "done" : state === "later" ? "later" : ""} ${warn ? "warn" : ""}`;
        if (state === "later" && !on)
          return (
            <span key={step} class={`${look} shut`} aria-disabled="true" title={needs} role="link">
              {inside}
            </span>
          );
        return (
          <a key={step} class={look} href={href.step(id, step)} aria-current={on ? "step" : undefined}>
            {inside}
          </a>
        );
      })}
      {steps.result.state !== "later" && (
        <a class={`nav beside ${here === "compare" ? "on" : ""}`} href={href.step(id, "compare")} aria-current={here === "compare" ? "page" : undefined}>
          <Icon name="template" />
          {t("compare")}
        </a>
      )}
    </nav>
  );
}

function NavRail({ here }: { here: Place["at"] }) {
  const places: [Place["at"], IconName, string, string][] = [
    ["cases", "folder", t("cases"), href.cases],
    ["cameras", "camera", t("cameras"), href.cameras],
    ["settings", "sliders", t("settings"), href.settings],
  ];
  return (
    <nav class="rail" aria-label={t("places")}>
      {places.map(([at, icon, text, to]) => (
        <a key={at} class={`nav ${here === at ? "on" : ""}`} href={to} aria-current={here === at ? "page" : undefined}>
          <Icon name={icon} />
          {text}
        </a>
      ))}
      <span class="grow" />
      <p class="small faint disclaimer">{t("disclaimer")}</p>
    </nav>
  );
}
