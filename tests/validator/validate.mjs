// node validate.mjs FILE…: prints the Khronos validator's report on each GLB, a JSON array.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";

const validator = createRequire(import.meta.url)("gltf-validator");

const reports = [];
for (const path of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(path)), { uri: path });
  reports.push(report);
}
console.log(JSON.stringify(reports));
