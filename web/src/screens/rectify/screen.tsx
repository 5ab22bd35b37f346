/**
 * Rectify: what changes, by how much? Regions are drawn and depths dragged on the limb; the recipe is
 * the list of what can be undone.
 *
 * While a hand drags, this page shows its own preview. After release the server tries the edit, and
 * what is shown then is what will be made. Kept edits stand in the recipe, which the server replays;
 * until it has answered, an edit that is being kept stays open and holds still.
 */
import { useMemo } from "preact/hooks";

import { Refused } from "../../api/client";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { widthOf } from "../../geometry/scales";
import { go, href } from "../../state/route";
import { type TextKey, t } from "../../texts";
import { Stage, type Shown } from "../../viewer/stage";
import type { Finding } from "../../words";
import { scanWords } from "../edit-words";
import { OtherEdit } from "../other-edit";
import type { CaseProps } from "../open-case";
import { TemplateEdits } from "../templates";
import { Against } from "./against";
import { type Workspace, unkept, useWorkspace } from "./workspace";
import { handleOf, linesOf, marksOf } from "./drawn";
import { DepthCard, EditForm } from "./edit-form";
import { type Girth, useGirth } from "./effect";
import { DrawingForm, TrimlineForm } from "./drawing-form";
import { useKeys } from "./keys";
import { changed } from "./ledger";
import { LedgerTable } from "./ledger-table";
import { RecipeList } from "./recipe-list";
import { useTool } from "./tool";
import { ToolBar } from "./tool-bar";

export function RectifyScreen({ openCase }: CaseProps) {
  const workspace = useWorkspace(openCase);
  const { mode, level, limb, ledger, base, edit, keeping } = workspace;
  useKeys(workspace);
  const tool = useTool(workspace);
  const girth = useGirth(workspace);
  const shown = useShown(workspace);
  const draft = edit.draft.value;
  return (
    <div class="work">
      <Stage
        shown={shown}
        label={t("stage.rectify")}
        mode={mode}
        modes={["surface", "difference", "sure"]}
        level={level}
        marks={marksOf(workspace)}
        lines={linesOf(workspace)}
        handle={handleOf(workspace)}
        onHandle={edit.pull}
        against={base.before === null ? scanWords(limb?.reply.sock_mm ?? 0, ledger.book?.recipe.edits ?? []) : t("against.before", base.before)}
        tool={draft || keeping.now.value ? null : tool}
        onReady={(made) => (workspace.viewer.current = made)}
        keys={draft ? t("rectify.keys.open") : t(`rectify.keys.${workspace.drawing.tool.value}` as TextKey)}
        tools={<ToolBar workspace={workspace} />}
      >
        {draft && <DepthCard draft={draft} girth={girth} />}
        {workspace.limbRefused.value && (
          <div class="stage-note">
            <Refusal refused={workspace.limbRefused.value} />
          </div>
        )}
      </Stage>
      <aside class="pane" aria-label={t("step.rectify")}>
        <h1 class="unseen">{t("step.rectify")}</h1>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("panel")}>
          <ToolForm workspace={workspace} girth={girth} />
          <Recipe workspace={workspace} />
        </div>
        <Next workspace={workspace} />
      </aside>
    </div>
  );
}

/** The limb as the trial would make it, else as it is, with its colours. */
function useShown({ limb, trial, base }: Workspace): Shown | null {
  const tried = trial.tried.value;
  return useMemo(() => {
    if (!limb) return null;
    const values = tried?.values ?? base.differences_mm;
    return { surface: tried?.surface ?? limb.fetched.data, frame: limb.frame, aligned: limb.reply.aligned, difference: { values, wider: widthOf(values) } };
  }, [limb, tried, base.differences_mm]);
}

/** The edit that is open, or the form of the tool in the hand. */
function ToolForm({ workspace, girth }: { workspace: Workspace; girth: Girth | null }) {
  const { openCase, limb, drawing, edit, trial, trimline, keeping, recipe } = workspace;
  const tool = drawing.tool.value;
  const draft = edit.draft.value;
  const tried = trial.tried.value;
  const [waits, refused, busy] = [trial.waits.value, trial.refused.value, keeping.now.value];
  return (
    <>
      {draft && <EditForm workspace={workspace} draft={draft} girth={girth} />}
      {!draft && trimline.points.value.length > 0 && <TrimlineForm workspace={workspace} />}
      {!unkept(workspace) && (tool === "region" || tool === "brush" || tool === "place") && <DrawingForm workspace={workspace} />}
      {(tool === "levels" || tool === "other") && (
        <OtherEdit
          key={tool}
          first={tool === "levels" ? "reduction" : (drawing.first ?? "sock")}
          only={tool === "levels" ? "levels" : null}
          limbKind={openCase.info.kind ?? null}
          places={limb?.reply.places.map((one) => one.name) ?? []}
          busy={busy}
          waits={waits}
          volume_ml={tried?.line ? changed(tried.line.volume) : null}
          refused={refused}
          onTry={edit.tryNew}
          onKeep={recipe.add}
          onDrop={edit.drop}
        />
      )}
      {tool === "template" && (
        <TemplateEdits
          openCase={openCase}
          tried={tried !== null}
          waits={waits}
          refused={refused}
          busy={busy}
          onTry={edit.tryNew}
          onKeep={(body) => void recipe.add(body)}
          onDrop={edit.drop}
        />
      )}
    </>
  );
}

/** What was kept: the recipe, what the colours are against, and the ledger. */
function Recipe({ workspace }: { workspace: Workspace }) {
  const { ledger, recipe, trial, level } = workspace;
  const { book } = ledger;
  return (
    <>
      <Refusal refused={recipe.refused ?? ledger.asked.refused.value} />
      {book && <RecipeList book={book} listed={ledger.listed} recipe={recipe} />}
      {book && <Against workspace={workspace} edits={book.recipe.edits} />}
      {book?.refusal && <Refusal refused={Refused.by("", book.refusal as Finding, 422)} />}
      {book?.ledger && book.ledger.lines.length > 0 && (
        <LedgerTable ledger={book.ledger} line={trial.tried.value?.line ?? null} level={level.value} onLevel={(height_mm) => (level.value = height_mm)} />
      )}
    </>
  );
}

function Next({ workspace }: { workspace: Workspace }) {
  const open = unkept(workspace);
  const lacks = open && t(open === "edit" ? "rectify.open" : "trimline.open");
  return (
    <div class="next">
      <Button
        go={!open && !["template", "levels", "other"].includes(workspace.drawing.tool.value)}
        big
        off={lacks}
        trailing={open ? undefined : "next"}
        onClick={() => go(href.step(workspace.openCase.id, "send"))}
      >
        {lacks ?? t("rectify.next")}
      </Button>
    </div>
  );
}
