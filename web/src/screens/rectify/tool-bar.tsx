/** The tools of this screen, beside the limb. */
import { Icon, type IconName } from "../../design/icons";
import { type TextKey, t } from "../../texts";
import type { Workspace } from "./workspace";
import type { ToolName } from "./drawing";

const TOOLS: readonly { name: ToolName; icon: IconName }[] = [
  { name: "place", icon: "place" },
  { name: "region", icon: "region" },
  { name: "brush", icon: "brush" },
  { name: "levels", icon: "levels" },
  { name: "trimline", icon: "trimline" },
  { name: "template", icon: "template" },
  { name: "other", icon: "more" },
];

export function ToolBar({ workspace: { drawing, edit } }: { workspace: Workspace }) {
  const take = (name: ToolName) => {
    edit.drop();
    drawing.clear(); // also while an edit is being kept, which is not dropped
    drawing.tool.value = name;
  };
  return (
    <div class="tools" role="toolbar" aria-label={t("rectify.tools")}>
      {TOOLS.map(({ name, icon }) => (
        <button
          key={name}
          type="button"
          class={`tool ${drawing.tool.value === name ? "on" : ""}`}
          aria-pressed={drawing.tool.value === name}
          onClick={() => take(name)}
        >
          <Icon name={icon} />
          {t(`tool.${name}` as TextKey)}
        </button>
      ))}
    </div>
  );
}
