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
  return (
    <div class="menu" ref={menu} onKeyDown={(event) => event.key === "Escape" && onClose()}>
      {children}
    </div>
  );
}
