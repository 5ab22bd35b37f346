/** The photos: one tile each, those on their way, those asked for; and what is known of the one that is chosen. */
import type { Schemas } from "../../api/client";
import { Icon } from "../../design/icons";
import { Button } from "../../design/parts";
import { Refusal } from "../../design/refusal";
import { bytes } from "../../numbers";
import { perform } from "../../state/acts";
import { useAct } from "../../state/requests";
import type { Upload } from "../../state/uploads";
import { t, tOr } from "../../texts";
import { told } from "../../words";
import { remarkInShort, remarkWords } from "../coach-words";
import type { OpenCase } from "../open-case";
import { pictureOf } from "../photo-picture";

interface PhotoProps {
  readonly openCase: OpenCase;
  readonly photo: Schemas["Photo"];
  /** What the check said of it. */
  readonly said: Schemas["CheckedReply"] | undefined;
}

export function PhotoTile({ openCase, photo, said, number, on, onClick }: PhotoProps & { number: number; on: boolean; onClick: () => void }) {
  const film = /\.(mp4|mov|avi|mkv|webm)$/i.test(photo.name);
  const unusable = photo.state === "unusable";
  const spare = photo.same_shot !== "";
  const bad = unusable || (said !== undefined && !said.counts);
  const first = said?.remarks[0];
  const remark = unusable ? t("capture.unusable") : spare ? t("capture.spare", photo.same_shot) : remarkWords(first);
  const short = unusable ? remark : first && remarkInShort(first);
  return (
    <button
      type="button"
      class={`ph ${bad ? "bad" : ""} ${spare ? "spare" : ""} ${on ? "on" : ""}`}
      title={[photo.name, remark].filter(Boolean).join(": ")}
      onClick={onClick}
      aria-pressed={on}
      aria-label={`${number}: ${photo.name} ${remark}`}
    >
      {film || unusable ? <Icon name="camera" /> : <img src={pictureOf(openCase.id, photo, 320)} alt="" loading="lazy" />}
      <span>{spare ? t("capture.spare.short", number) : bad && short ? `${number} ${short}` : number}</span>
    </button>
  );
}

/** What a part of a photo's header is called. */
const headerName = (part: string): string => tOr(`header.${part}`, part);

/** A photo on its way. */
export function UploadTile({ one }: { one: Upload }) {
  return (
    <div class={`ph wait ${one.state}`} title={one.message || one.name}>
      <span class="where-to">
        {one.state === "refused" ? t("capture.refused") : one.state === "offline" ? t("capture.offline") : one.name}
        <br />
        {one.state === "refused" ? one.name : `${bytes(one.sent)} / ${bytes(one.total)}`}
      </span>
      {one.state !== "refused" && (
        <svg class="upload-bar" viewBox="0 0 100 4" preserveAspectRatio="none" aria-hidden="true">
          <rect width={(100 * one.sent) / Math.max(1, one.total)} height="4" />
        </svg>
      )}
    </div>
  );
}

/** What is known of the photo that is chosen, and how to take it away. */
export function PhotoNote({ openCase, photo, said, onGone }: PhotoProps & { onGone: () => void }) {
  const act = useAct();
  const remove = () =>
    act.run(async () => {
      await perform(openCase.id, "delete", "/api/v1/cases/{case_id}/photos/{name}", { params: { path: { case_id: openCase.id, name: photo.name } } });
      onGone();
    });
  return (
    <div class="card photo-note">
      <b>{photo.name}</b>
      <p class="soft small-note">
        {[
          photo.width_px ? `${photo.width_px} × ${photo.height_px}` : "",
          bytes(photo.bytes),
          photo.same_shot ? t("capture.spare", photo.same_shot) : "",
          photo.removed.length ? t("capture.removed", photo.removed.map(headerName).join(", ")) : "",
          photo.kept.length ? t("capture.kept.one", photo.kept.map(headerName).join(", ")) : "",
        ]
          .filter(Boolean)
          .join(". ")}
      </p>
      {(said?.remarks.length || photo.problem) && (
        <p class="small-note">{[...(photo.problem ? [photo.problem] : []), ...(said?.remarks ?? [])].map((one) => told(one).replace(/\.$/, "")).join(". ")}</p>
      )}
      <Refusal refused={act.refused.value} />
      <div class="acts">
        <a class="btn" href={pictureOf(openCase.id, photo, 2400)} target="_blank" rel="noreferrer">
          {t("capture.large")}
        </a>
        <Button onClick={() => void remove()}>{t("take.out")}</Button>
      </div>
    </div>
  );
}
