/** News from the server: told which subjects changed, whoever listens asks for the rest. */
import { ROOT, link } from "./client";

/** Listen until the returned function is called; told again after the way was lost and found. */
export function listen(path: string, heard: (changed: readonly string[]) => void): () => void {
  let source: EventSource | null = null;
  let ended = false;
  let wait = 0;
  const open = () => {
    source = new EventSource(`${ROOT}${path}`, { withCredentials: true });
    source.addEventListener("change", (event: MessageEvent<string>) => {
      link.value = "open";
      heard((JSON.parse(event.data) as { changed: string[] }).changed);
    });
    source.onerror = () => {
      source?.close();
      if (!ended) wait = window.setTimeout(open, 2000);
    };
  };
  open();
  return () => {
    ended = true;
    clearTimeout(wait);
    source?.close();
  };
}
