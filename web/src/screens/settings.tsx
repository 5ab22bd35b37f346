/** Settings: language, theme, this program, one more browser. */
import { useSignal } from "@preact/signals";

import { answerOf, api } from "../api/client";
import { Button, Segments } from "../design/parts";
import { Refusal } from "../design/refusal";
import { fixed } from "../numbers";
import { useAct, useQuery } from "../state/requests";
import { type Theme, expert, setExpert, setTheme, theme } from "../state/settings";
import { LANGUAGES, type Language, language, setLanguage, t } from "../texts";

export function SettingsScreen() {
  const session = useQuery(() => answerOf(api.GET("/api/v1/session", {})), []);
  const link = useSignal("");
  const act = useAct();
  const make = () =>
    act.run(async () => {
      link.value = (await answerOf(api.POST("/api/v1/session/links", {}))).url;
    });
  const one = session.value.value;
  return (
    <main class="cases settings" id="content" tabIndex={-1}>
      <h1>{t("settings")}</h1>
      <section class="card">
        <h2>{t("settings.look")}</h2>
        <div class="setting">
          <span>{t("settings.language")}</span>
          <Segments
            label={t("settings.language")}
            value={language.value}
            options={(Object.entries(LANGUAGES) as [Language, string][]).map(([value, text]) => ({ value, text }))}
            onChange={setLanguage}
          />
        </div>
        <div class="setting">
          <span>{t("settings.theme")}</span>
          <Segments
            label={t("settings.theme")}
            value={theme.value}
            options={(["system", "light", "dark"] as const).map((value: Theme) => ({ value, text: t(`settings.theme.${value}`) }))}
            onChange={setTheme}
          />
        </div>
        <div class="setting">
          <span>
            {t("expert")}
            <br />
            <small class="faint">{t("settings.expert.what")}</small>
          </span>
          <Segments
            label={t("expert")}
            value={expert.value ? "on" : "off"}
            options={[
              { value: "off", text: t("off") },
              { value: "on", text: t("on") },
            ]}
            onChange={(value) => setExpert(value === "on")}
          />
        </div>
      </section>
      <section class="card">
        <h2>{t("settings.browser")}</h2>
        <p class="soft">{t("settings.browser.what")}</p>
        <Refusal refused={act.refused.value ?? session.refused.value} />
        <div class="acts">
          <Button onClick={() => void make()}>{t("settings.link")}</Button>
        </div>
        {link.value && (
          <p class="mono" role="status">
            {link.value}
          </p>
        )}
      </section>
      <section class="card">
        <h2>{t("settings.program")}</h2>
        {one && (
          <p class="soft">
            limbgram {one.version}. {t("settings.machine", one.processors, fixed(one.memory_mb / 1024, 0))} {t(one.network ? "local.clinic" : "local")}.
          </p>
        )}
        <p class="soft">{t("disclaimer")}</p>
        <p class="small faint">
          <a href="/licences.txt" target="_blank" rel="noreferrer">
            {t("settings.licences")}
          </a>
        </p>
      </section>
    </main>
  );
}
