// Reads files of splats with programs from npm, and prints what they say as JSON: {glb: report, ply: {...}, spz: {...}}.
//
//     node check.mjs MODULES FOLDER      MODULES holds node_modules, FOLDER scene.glb, scene.ply and scene.spz
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const [modules, folder] = process.argv.slice(2);
const require = createRequire(join(modules, "node_modules", "x.js"));
const found = {};

const validator = require("gltf-validator");
const report = await validator.validateBytes(new Uint8Array(readFileSync(join(folder, "scene.glb"))), { maxIssues: 0 });
found.glb = { issues: report.issues, info: report.info };

const program = join(modules, "node_modules", "@playcanvas", "splat-transform", "bin", "cli.mjs");
for (const name of ["ply", "spz"]) {
  const out = join(folder, `from_${name}.ply`);
  const told = execFileSync("node", [program, "-w", join(folder, `scene.${name}`), out], { encoding: "utf8", stdio: "pipe" });
  found[name] = { told, out };
}
console.log(JSON.stringify(found));
