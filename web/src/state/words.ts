/**
 * What the server tells once, fetched as soon as it answers: the words of findings, for each language, and the kinds
 * of edits, of limbs and of files.
 */
import { effect } from "@preact/signals";

import { answerOf, api, link } from "../api/client";
import { editKinds } from "../edits";
import { exportKinds, shapeFiles } from "../formats";
import { limbKinds } from "../limb-kinds";
import { language } from "../texts";
import { words } from "../words";

export function watchWords(): void {
  once(
    () => words.peek()[language.value] !== undefined,
    async () => {
      const spoken = language.peek();
      const told = await answerOf(api.GET("/api/v1/words/{language}", { params: { path: { language: spoken } } }));
      words.value = { ...words.peek(), [spoken]: told };
    },
  );
  once(
    () => editKinds.peek().length > 0,
    async () => void (editKinds.value = await answerOf(api.GET("/api/v1/edits", {}))),
  );
  once(
    () => limbKinds.peek().length > 0,
    async () => void (limbKinds.value = await answerOf(api.GET("/api/v1/limb-kinds", {}))),
  );
  once(
    () => exportKinds.peek().length > 0,
    async () => {
      const [written, read] = await Promise.all([answerOf(api.GET("/api/v1/exports", {})), answerOf(api.GET("/api/v1/shape-files", {}))]);
      exportKinds.value = written;
      shapeFiles.value = read;
    },
  );
}

/** Fetch what is not here whenever the way to the server opens; until it answers, what the page has of its own stands. */
function once(isHere: () => boolean, fetch: () => Promise<void>): void {
  effect(() => {
    const here = isHere();
    if (link.value === "open" && !here) fetch().catch(() => undefined);
  });
}
