/** The template that is chosen and how strongly it is applied; the edit that it makes is tried at once. */
import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

import { bytesOf } from "../../api/client";
import type { useAct } from "../../state/requests";
import type { EditBody } from "../rectify/draft";

export interface Chosen {
  /** Empty: none. */
  readonly id: Signal<string>;
  /** Per cent. */
  readonly strength: Signal<number>;
  readonly edit: () => Promise<EditBody>;
}

export function useChosen({ run }: Pick<ReturnType<typeof useAct>, "run">, isReadable: (id: string) => boolean, onTry: (edit: EditBody) => void): Chosen {
  const id = useSignal("");
  const strength = useSignal(100);
  /** What was fetched, by the template's id. */
  const files = useRef(new Map<string, string>());
  const edit = async (): Promise<EditBody> => {
    const [of, share] = [id.value, strength.value / 100];
    const text = files.current.get(of) ?? new TextDecoder().decode((await bytesOf(`/templates/${of}/file`)).bytes);
    files.current.set(of, text);
    return { kind: "from-template", parameters: { learned: text, strength: share }, accept: [] };
  };
  useEffect(() => {
    if (!isReadable(id.value)) return;
    let overtaken = false;
    void run(async () => {
      const made = await edit();
      if (!overtaken) onTry(made);
    });
    return () => {
      overtaken = true;
    };
  }, [id.value, strength.value]);
  return { id, strength, edit };
}
