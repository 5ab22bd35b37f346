/** Where the picture of a photo is: of another photo that takes its name it is elsewhere, so that no browser shows what it had. */
import { ROOT, type Schemas } from "../api/client";

export const pictureOf = (caseId: string, { name, sha256 }: Pick<Schemas["Photo"], "name" | "sha256">, width_px: number): string =>
  `${ROOT}/cases/${caseId}/photos/${encodeURIComponent(name)}/picture?width=${width_px}&of=${sha256.slice(0, 8)}`;
