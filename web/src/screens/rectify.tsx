import type { RoomProps } from "./room";
export function RectifyScreen(_: RoomProps) {
  return <main id="content" />;
}
