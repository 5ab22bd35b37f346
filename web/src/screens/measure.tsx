import type { RoomProps } from "./room";
export function MeasureScreen(_: RoomProps) {
  return <main id="content" />;
}
