/** What every screen of a case is given. */
import type { Schemas } from "../api/client";

export interface Room {
  readonly id: string;
  readonly info: Schemas["Case"];
  /** How often each subject changed since the page was opened: photos, check, job, work, case. */
  readonly news: Readonly<Record<string, number>>;
  readonly again: () => Promise<void>;
}

export interface RoomProps {
  readonly room: Room;
}
