/** The client's entry: the theme, the language, and the app in its place. */
import { render } from "preact";

import { App } from "./app";
import "./design/tokens.css";
import "./design/base.css";
import "./design/cases.css";
import "./design/phone.css";
import { Gate } from "./screens/gate";
import { watch } from "./state/person";
import { applyTheme } from "./state/settings";
import { watchWords } from "./state/words";
import { language } from "./texts";

applyTheme();
document.documentElement.lang = language.value;
watch();
watchWords();
render(
  <Gate>
    <App />
  </Gate>,
  document.getElementById("app") as HTMLElement,
);
