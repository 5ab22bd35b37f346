import type { RoomProps } from "./room";
export function RecordScreen(_: RoomProps) {
  return <main id="content" />;
}
