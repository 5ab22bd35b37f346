/** Keys of this screen, and the wheel that is the brush's size. */
import { useEffect } from "preact/hooks";

import { type Workspace, keepDrawn } from "./workspace";
import { SIZE_MM, SOFT_MM, sizeBy } from "./drawing";

export function useKeys(workspace: Workspace): void {
  useEffect(() => {
    const key = (event: KeyboardEvent) => onKey(workspace, event);
    const wheel = (event: WheelEvent) => onWheel(workspace, event);
    addEventListener("keydown", key);
    // Before the canvas takes it for coming nearer.
    addEventListener("wheel", wheel, { capture: true, passive: false });
    return () => {
      removeEventListener("keydown", key);
      removeEventListener("wheel", wheel, { capture: true });
    };
  });
}

function onKey(workspace: Workspace, event: KeyboardEvent): void {
  const { drawing, edit, trimline, recipe } = workspace;
  const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
  const letter = event.ctrlKey || event.metaKey ? event.key.toLowerCase() : "";
  if (letter === "z" && !typing) {
    event.preventDefault();
    if (event.shiftKey) recipe.redo();
    else recipe.undo();
  } else if (letter === "y" && !typing) {
    event.preventDefault();
    recipe.redo();
  } else if (event.key === "Escape") edit.drop();
  else if (event.key === "Enter" && edit.draft.value && !typing && !(event.target instanceof HTMLButtonElement)) keepDrawn(workspace);
  else if (event.key === "Backspace" && !typing && trimline.points.value.length) trimline.back();
  else if (event.key === "[" && !typing) sizeBy(drawing.size, -1, SIZE_MM);
  else if (event.key === "]" && !typing) sizeBy(drawing.size, 1, SIZE_MM);
  else if (event.key === ";" && !typing) sizeBy(drawing.soft, -1, SOFT_MM);
  else if (event.key === "'" && !typing) sizeBy(drawing.soft, 1, SOFT_MM);
}

function onWheel({ drawing, viewer }: Workspace, event: WheelEvent): void {
  if (!event.altKey || drawing.tool.value !== "brush" || event.target !== viewer.current?.canvas) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  sizeBy(drawing.size, -Math.sign(event.deltaY || event.deltaX), SIZE_MM);
}
