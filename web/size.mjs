/** The client's size as it travels, compressed; fails beyond the budget. Runs as `node size.mjs FOLDER`. */
import { readFileSync, readdirSync, statSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

const BUDGET_KB = 450;

function* files(folder) {
  for (const name of readdirSync(folder)) {
    const path = join(folder, name);
    if (statSync(path).isDirectory()) yield* files(path);
    else yield path;
  }
}

let all = 0;
for (const path of files(process.argv[2])) {
  if (path.endsWith(".txt")) continue; // licences travel only when they are read
  const content = readFileSync(path);
  all += path.endsWith(".woff2") ? content.length : gzipSync(content, { level: 9 }).length;
}
const kB = all / 1000;
process.stdout.write(`The client is ${kB.toFixed(0)} kB compressed; ${BUDGET_KB} kB are allowed.\n`);
process.exit(kB > BUDGET_KB ? 1 : 0);
