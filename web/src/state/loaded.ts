/** A part of the page that comes in a file of its own. */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";

/** What belongs to a name, once it is loaded; null until then, however late what was asked for before comes. */
export function useLoaded<N, P>(name: N, load: (name: N) => Promise<P>): P | null {
  const loaded = useSignal<{ readonly of: N; readonly part: P } | null>(null);
  useEffect(() => {
    let overtaken = false;
    void load(name).then((part) => {
      if (!overtaken) loaded.value = { of: name, part };
    });
    return () => {
      overtaken = true;
    };
  }, [name]);
  return loaded.value?.of === name ? loaded.value.part : null;
}
