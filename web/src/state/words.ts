/** Fetches the words of findings, once for each language, the kinds of edits, limbs and files, as soon as the server answers. */
import { effect } from "@preact/signals";

import { api, link, taken } from "../api/client";
import { kinds } from "../edits";
import { exportKinds, shapeFiles } from "../formats";
import { limbKinds } from "../limb-kinds";
import { language } from "../texts";
import { words } from "../words";

export function watchWords(): void {
  effect(() => {
    const spoken = language.value;
    if (link.value !== "open" || words.peek()[spoken]) return;
    taken(api.GET("/api/v1/words/{language}", { params: { path: { language: spoken } } })).then(
      (got) => {
        words.value = { ...words.peek(), [spoken]: got };
      },
      () => undefined, // English sentences stand till it answers
    );
  });
  effect(() => {
    if (link.value !== "open" || kinds.peek().length) return;
    taken(api.GET("/api/v1/edits", {})).then(
      (got) => {
        kinds.value = got;
      },
      () => undefined, // names of the recipe stand till it answers
    );
  });
  effect(() => {
    if (link.value !== "open" || limbKinds.peek().length) return;
    taken(api.GET("/api/v1/limb-kinds", {})).then(
      (got) => {
        limbKinds.value = got;
      },
      () => undefined, // the kinds' own names stand till it answers
    );
  });
  effect(() => {
    if (link.value !== "open" || exportKinds.peek().length) return;
    Promise.all([taken(api.GET("/api/v1/exports", {})), taken(api.GET("/api/v1/shape-files", {}))]).then(
      ([written, read]) => {
        exportKinds.value = written;
        shapeFiles.value = read;
      },
      () => undefined, // nothing is offered till it answers
    );
  });
}
