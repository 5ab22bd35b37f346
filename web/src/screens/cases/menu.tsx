/** A menu that closes by a press elsewhere, and by Escape. */
import { useEffect, useRef } from "preact/hooks";

export function Menu({ children, onClose }: { children: preact.ComponentChildren; onClose: () => void }) {
  const menu = useRef<HTMLDivElement>(null);
  useEffect(() => {
    menu.current?.querySelector("button")?.focus();
    const away = (event: PointerEvent) => {
      if (!menu.current?.parentElement?.contains(event.target as Node)) onClose();
    };
    addEventListener("pointerdown", away);
    return () => removeEventListener("pointerdown", away);
  }, []);
  /** By Escape the focus goes back to the button that opened it. */
  const close = (event: KeyboardEvent) => {
    if (event.key !== "Escape") return;
    menu.current?.parentElement?.querySelector("button")?.focus();
    onClose();
  };
  return (
    <div class="menu" ref={menu} onKeyDown={close}>
      {children}
    </div>
  );
}
