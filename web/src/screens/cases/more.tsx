/** The menu of what can be done to a case. */
import { useSignal } from "@preact/signals";

import type { Schemas } from "../../api/client";
import { Button } from "../../design/parts";
import { t } from "../../texts";
import type { ActsOfCase } from "./acts-of-case";
import { Menu } from "./menu";

export function More({ one, acts }: { one: Schemas["Case"]; acts: ActsOfCase }) {
  const open = useSignal(false);
  const close = () => (open.value = false);
  /** Closed by what is done, once it is done. */
  const then = async (done: Promise<unknown>) => {
    if ((await done) !== null) close();
  };
  return (
    <div class="more">
      <Button bare icon="more" class="icon-only" label={`${t("cases.th.more")}: ${one.id}`} pressed={open.value} onClick={() => (open.value = !open.value)} />
      {open.value && (
        <Menu onClose={close}>
          <button type="button" onClick={() => ((acts.doing.value = "rename"), close())}>
            {t("cases.rename")}
          </button>
          <button type="button" onClick={() => void then(acts.change({ archived: !one.archived }))}>
            {t(one.archived ? "cases.from.archive" : "cases.to.archive")}
          </button>
          <button type="button" onClick={() => void then(acts.ask("clear"))}>
            {t("cases.clear.parts")}
          </button>
          <button type="button" class="danger" onClick={() => void then(acts.ask("delete"))}>
            {t("cases.delete")}
          </button>
        </Menu>
      )}
    </div>
  );
}
