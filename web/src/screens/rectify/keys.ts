/** Keys of this screen, and the wheel that is the brush's size. */
import { useEffect } from "preact/hooks";

import { type Bench, keepDrawn } from "./bench";
import { SIZE_MM, SOFT_MM, sizeBy } from "./hand";

export function useKeys(bench: Bench): void {
  useEffect(() => {
    const key = (event: KeyboardEvent) => onKey(bench, event);
    const wheel = (event: WheelEvent) => onWheel(bench, event);
    addEventListener("keydown", key);
    // Before the canvas takes it for coming nearer.
    addEventListener("wheel", wheel, { capture: true, passive: false });
    return () => {
      removeEventListener("keydown", key);
      removeEventListener("wheel", wheel, { capture: true });
    };
  });
}

function onKey(bench: Bench, event: KeyboardEvent): void {
  const { hand, edit, trimline, recipe } = bench;
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
  else if (event.key === "Enter" && edit.draft.value && !typing && !(event.target instanceof HTMLButtonElement)) keepDrawn(bench);
  else if (event.key === "Backspace" && !typing && trimline.points.value.length) trimline.back();
  else if (event.key === "[" && !typing) sizeBy(hand.size, -1, SIZE_MM);
  else if (event.key === "]" && !typing) sizeBy(hand.size, 1, SIZE_MM);
  else if (event.key === ";" && !typing) sizeBy(hand.soft, -1, SOFT_MM);
  else if (event.key === "'" && !typing) sizeBy(hand.soft, 1, SOFT_MM);
}

function onWheel({ hand, viewer }: Bench, event: WheelEvent): void {
  if (!event.altKey || hand.tool.value !== "brush" || event.target !== viewer.current?.canvas) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  sizeBy(hand.size, -Math.sign(event.deltaY || event.deltaX), SIZE_MM);
}
