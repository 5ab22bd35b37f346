/**
 * Files on their way to the clinic machine, in pieces, three at a time.
 *
 * What is shown as arrived is what the server says it holds. After a broken line the server is asked
 * how many bytes it has, and the rest is sent from there; nothing is sent twice and nothing is lost
 * while the page stays open. Uploads go on when another screen is looked at. Each has an id of its
 * own: two phones may count their photos alike, and no photo is put together of two.
 */
import { signal } from "@preact/signals";

import { ROOT, Refused, type Schemas, answerOf, api, link, noteStatus, refusedBy } from "../api/client";
import { t } from "../texts";

export interface Upload {
  readonly name: string;
  readonly total: number;
  /** Bytes that the server has answered for, and those on their way. */
  readonly sent: number;
  readonly state: "waiting" | "sending" | "offline" | "here" | "refused";
  readonly message: string;
}

const PIECE_BYTES = 4 * 1024 * 1024;
const AT_ONCE = 3;
const RETRY_MS = 2500;
/** How often the server is asked for a file that it has whole and looks at. */
const MOST_LOOKS = 120;
const LARGEST_HASHED_BYTES = 64 * 1024 * 1024;

export const uploads = signal<ReadonlyMap<string, readonly Upload[]>>(new Map());

interface Waiting {
  readonly file: File;
  readonly name: string;
}

interface Queue {
  readonly waiting: Waiting[];
  /** Those that wait or are sent, by their names there. */
  readonly going: Map<string, File>;
  busy: number;
  done: () => void;
}

const queues = new Map<string, Queue>();

/** Send files to a case; `done` is called whenever one is there. */
export function send(caseId: string, files: readonly File[], done: () => void): void {
  const queue: Queue = queues.get(caseId) ?? { waiting: [], going: new Map(), busy: 0, done };
  queue.done = done;
  queues.set(caseId, queue);
  for (const file of files) {
    const name = nameApart(file, queue.going);
    if (!name) continue;
    queue.going.set(name, file);
    put(caseId, { name, total: file.size, sent: 0, state: "waiting", message: "" });
    queue.waiting.push({ file, name });
  }
  for (let k = 0; k < AT_ONCE; k++) void work(caseId);
}

/** What of a case is not with the server yet. */
export interface Outstanding {
  readonly onTheirWay: readonly Upload[];
  readonly refused: readonly Upload[];
}

/** The uploads of a case without those that the server holds by now. */
export function outstanding(caseId: string, held: readonly { readonly name: string }[]): Outstanding {
  const left = (uploads.value.get(caseId) ?? []).filter((one) => one.state !== "here" && !held.some((photo) => photo.name === one.name));
  return { onTheirWay: left.filter((one) => one.state !== "refused"), refused: left.filter((one) => one.state === "refused") };
}

/** Uploads of a case that need no more looking at are forgotten. */
export function forgetDone(caseId: string): void {
  const rest = (uploads.value.get(caseId) ?? []).filter((one) => one.state !== "here" && one.state !== "refused");
  uploads.value = new Map(uploads.value).set(caseId, rest);
}

/** Photos of phones are all called image.jpg: the time they were taken tells them apart. */
export function uploadName(file: { name: string; lastModified: number }): string {
  const clean = file.name.replace(/[\\/:*?"<>|\u0000-\u001f]/g, "_").slice(-120);
  if (!/^image\.(jpe?g|heic)$/i.test(clean)) return clean;
  const at = new Date(file.lastModified)
    .toISOString()
    .replace(/[-:TZ.]/g, "")
    .slice(0, 17);
  return clean.replace(/^image/i, `photo-${at}`);
}

/** The name of a file apart from those of others on their way, as photos of two folders may have one; null for one that is among them. */
function nameApart(file: File, going: ReadonlyMap<string, File>): string | null {
  const own = uploadName(file);
  for (let name = own, number = 2; ; number++) {
    const other = going.get(name);
    if (!other) return name;
    if (other.size === file.size && other.lastModified === file.lastModified) return null;
    name = own.replace(/(\.[^.]*)?$/, `-${number}$1`);
  }
}

function put(caseId: string, upload: Upload): void {
  const others = (uploads.value.get(caseId) ?? []).filter((one) => one.name !== upload.name);
  const order = uploads.value.get(caseId)?.findIndex((one) => one.name === upload.name) ?? -1;
  const list = order < 0 ? [...others, upload] : [...others.slice(0, order), upload, ...others.slice(order)];
  uploads.value = new Map(uploads.value).set(caseId, list);
}

async function work(caseId: string): Promise<void> {
  const queue = queues.get(caseId);
  if (!queue || queue.busy >= AT_ONCE) return;
  const next = queue.waiting.shift();
  if (!next) return;
  queue.busy++;
  try {
    await sendOne(caseId, next.name, next.file);
  } finally {
    queue.busy--;
    queue.going.delete(next.name);
    queue.done();
    void work(caseId);
  }
}

async function sendOne(caseId: string, name: string, file: File): Promise<void> {
  let from = 0;
  const upload = newId();
  const say = (state: Upload["state"], sent: number, message = "") => put(caseId, { name, total: file.size, sent, state, message });
  for (;;) {
    try {
      for (;;) {
        const to = Math.min(file.size, from + PIECE_BYTES);
        say("sending", from);
        const answer = await piece(caseId, name, upload, file, from, to, (loaded) => say("sending", from + loaded));
        if (answer.whole) {
          if (await isOther(file, answer.photos)) say("refused", from, t("capture.other.bytes"));
          else say("here", file.size);
          return;
        }
        from = answer.bytes;
      }
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      if (!error.unanswered) {
        say("refused", from, error.message);
        return;
      }
      say("offline", from);
      try {
        from = await whenBack(caseId, name, file.size);
      } catch (why) {
        if (!(why instanceof Refused)) throw why;
        say("refused", from, why.message);
        return;
      }
    }
  }
}

/** Wait until the server answers again, or somebody is signed in again; how many bytes of the file it has. */
async function whenBack(caseId: string, name: string, total: number): Promise<number> {
  for (let looks = 0; ;) {
    await new Promise((go) => setTimeout(go, RETRY_MS));
    try {
      const list = await answerOf(api.GET("/api/v1/cases/{case_id}/photos", { params: { path: { case_id: caseId } } }));
      const there = list.photos.find((one) => one.name === name);
      if (there?.state !== "arriving") return 0;
      if (there.bytes < total) return there.bytes;
      if (looks++ >= MOST_LOOKS) return 0;
    } catch (error) {
      if (!(error instanceof Refused) || !error.unanswered) throw error;
    }
  }
}

/** Tells a file from that of another sender that has the same name. */
function newId(): string {
  return [...crypto.getRandomValues(new Uint8Array(12))].map((one) => one.toString(16).padStart(2, "0")).join("");
}

/** Whether the server took other bytes for this file; a browser hashes over a safe line only. */
async function isOther(file: File, photos: readonly Schemas["Photo"][]): Promise<boolean> {
  if (photos.length !== 1 || /\.zip$/i.test(file.name) || file.size > LARGEST_HASHED_BYTES || !globalThis.crypto?.subtle) return false;
  const content = await file.arrayBuffer().catch(() => null); // its card may be gone since
  if (!content) return false;
  const hash = new Uint8Array(await crypto.subtle.digest("SHA-256", content));
  return [...hash].map((one) => one.toString(16).padStart(2, "0")).join("") !== photos[0].sha256;
}

function piece(
  caseId: string,
  name: string,
  upload: string,
  file: File,
  from: number,
  to: number,
  progress: (loaded: number) => void,
): Promise<Schemas["Sent"]> {
  return new Promise((good, bad) => {
    const request = new XMLHttpRequest();
    request.open("PUT", `${ROOT}/cases/${encodeURIComponent(caseId)}/photos/${encodeURIComponent(name)}`);
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.setRequestHeader("Upload-Id", upload);
    if (file.size > PIECE_BYTES) request.setRequestHeader("Content-Range", `bytes ${from}-${to - 1}/${file.size}`);
    request.responseType = "json";
    request.upload.onprogress = (event) => progress(event.loaded);
    request.onload = () => {
      noteStatus(request.status);
      if (request.status >= 200 && request.status < 300) good(request.response as Schemas["Sent"]);
      else bad(refusedBy(request.status, request.response));
    };
    request.onerror = () => {
      link.value = "lost";
      bad(Refused.lost());
    };
    request.send(file.slice(from, to));
  });
}

/** The files of a drop, folders opened. */
export async function filesOf(transfer: DataTransfer): Promise<File[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter((one) => one !== null);
  if (!entries.length) return [...transfer.files];
  const found: File[] = [];
  const open = async (entry: FileSystemEntry): Promise<void> => {
    if (entry.isFile) found.push(await new Promise<File>((good, bad) => (entry as FileSystemFileEntry).file(good, bad)));
    else if (entry.isDirectory) {
      const reader = (entry as FileSystemDirectoryEntry).createReader();
      for (;;) {
        const some = await new Promise<FileSystemEntry[]>((good, bad) => reader.readEntries(good, bad));
        if (!some.length) break;
        for (const one of some) await open(one);
      }
    }
  };
  for (const entry of entries) await open(entry);
  return found.filter((file) => !file.name.startsWith("."));
}
