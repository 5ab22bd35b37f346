import type { RoomProps } from "./room";
export function SendScreen(_: RoomProps) {
  return <main id="content" />;
}
