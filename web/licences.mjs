/** The licences of all that is built into the client, as one text beside it. Runs before the build. */
import { existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";

const { dependencies } = JSON.parse(readFileSync("package.json", "utf8"));
const seen = new Map();
const allowed = /^(MIT|ISC|BSD-2-Clause|BSD-3-Clause|Apache-2\.0|OFL-1\.1|0BSD)$/;

function add(name) {
  if (seen.has(name)) return;
  const folder = `node_modules/${name}`;
  const about = JSON.parse(readFileSync(`${folder}/package.json`, "utf8"));
  if (!allowed.test(about.license)) throw new Error(`${name} is under ${about.license}, which is not permissive.`);
  const file = readdirSync(folder).find((one) => /^(licen[cs]e|copying)/i.test(one));
  seen.set(name, `${name} ${about.version} (${about.license})\n\n${file ? readFileSync(`${folder}/${file}`, "utf8").trim() : about.license}\n`);
  for (const next of Object.keys(about.dependencies ?? {})) if (existsSync(`node_modules/${next}`)) add(next);
}

for (const name of Object.keys(dependencies).sort()) add(name);
writeFileSync("public/licences.txt", [...seen.entries()].sort().map(([, text]) => text).join(`\n${"-".repeat(80)}\n\n`));
