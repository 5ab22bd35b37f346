import type { RoomProps } from "./room";
export function AlignScreen(_: RoomProps) {
  return <main id="content" />;
}
