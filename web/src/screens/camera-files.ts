/** Where a file of a camera goes: a camera file, or a photo of the board under a name that tells it from the others of a phone. */
import { uploadName } from "../state/uploads";

export const placeOf = (cameraId: string, file: { name: string; lastModified: number }): string =>
  `/cameras/${cameraId}/${/\.json$/i.test(file.name) ? `file?name=${encodeURIComponent(file.name)}` : `photos/${encodeURIComponent(uploadName(file))}`}`;
