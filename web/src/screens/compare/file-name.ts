/** Names of files that people send. */
/** A name that the server takes: letters, digits and a known ending. */
export function shapeFileName(file: string): string {
  const dot = file.lastIndexOf(".");
  const stem = (dot < 0 ? file : file.slice(0, dot))
    .normalize("NFKD")
    .replace(/[^A-Za-z0-9 _-]+/g, "-")
    .replace(/^[^A-Za-z0-9]+/, "")
    .slice(0, 60);
  return `${stem || "shape"}.${dot < 0 ? "" : file.slice(dot + 1).toLowerCase()}`;
}
