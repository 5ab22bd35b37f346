/** The tools of this screen, beside the limb. */
import { Icon, type IconName } from "../../design/icons";
import { type TextKey, t } from "../../texts";
import type { Bench } from "./bench";
import type { ToolName } from "./hand";

const TOOLS: readonly { name: ToolName; icon: IconName }[] = [
  { name: "place", icon: "place" },
  { name: "region", icon: "region" },
  { name: "brush", icon: "brush" },
  { name: "levels", icon: "levels" },
  { name: "trimline", icon: "trimline" },
  { name: "template", icon: "template" },
  { name: "other", icon: "more" },
];

export function ToolBar({ bench: { hand, edit } }: { bench: Bench }) {
  const take = (name: ToolName) => {
    edit.drop();
    hand.corners.current = [];
    hand.tool.value = name;
  };
  return (
    <div class="tools" role="toolbar" aria-label={t("rectify.tools")}>
      {TOOLS.map(({ name, icon }) => (
        <button
          key={name}
          type="button"
          class={`tool ${hand.tool.value === name ? "on" : ""}`}
          aria-pressed={hand.tool.value === name}
          onClick={() => take(name)}
        >
          <Icon name={icon} />
          {t(`tool.${name}` as TextKey)}
        </button>
      ))}
    </div>
  );
}
