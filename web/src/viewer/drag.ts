/** A handle that a pointer holds. */

/** Tell of each move of a pointer until it lets go, or is taken away as by a scroll: then where it was last counts. */
export function dragged(down: PointerEvent, moved: (now: PointerEvent, done: boolean) => void): void {
  down.preventDefault();
  down.stopPropagation();
  const ended = new AbortController();
  let last = down;
  const heard = (event: PointerEvent) => {
    if (event.pointerId !== down.pointerId) return;
    const done = event.type !== "pointermove";
    if (event.type !== "pointercancel") last = event;
    if (done) ended.abort();
    moved(last, done);
  };
  for (const what of ["pointermove", "pointerup", "pointercancel"] as const) window.addEventListener(what, heard, { signal: ended.signal });
}
