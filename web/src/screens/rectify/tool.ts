/** The tool in the hand, as the canvas takes it. */
import { useEffect, useMemo, useRef } from "preact/hooks";

import type { Tool } from "../../viewer/viewer";
import type { Workspace } from "./workspace";
import { brushTool } from "./tools/brush";
import { placeTool } from "./tools/place";
import { regionTool } from "./tools/region";
import { trimlineTool } from "./tools/trimline";

/** The tool of the hand; null where edits are not drawn on the limb. It is made once a kind; what it works on is of the latest render. */
export function useTool(workspace: Workspace): Tool | null {
  const { viewer, drawing, edit, limb } = workspace;
  const what = drawing.tool.value;
  const drawn = edit.draft.value !== null;
  useEffect(() => {
    const v = viewer.current;
    if (!v) return;
    v.onHover = what === "brush" && !drawn ? (hit) => (drawing.over.value = hit) : null;
    drawing.over.value = null;
  }, [what, drawn, limb]);
  const latest = useRef(workspace);
  latest.current = workspace;
  return useMemo(() => {
    const now = () => latest.current;
    if (what === "place") return placeTool(now);
    if (what === "region") return regionTool(now);
    if (what === "brush") return brushTool(now);
    return what === "trimline" ? trimlineTool(now) : null;
  }, [what]);
}
