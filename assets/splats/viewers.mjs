// Draws a PLY of splats in viewers from npm, with their own defaults, in a headless Chromium with software OpenGL.
//
//     npm install @sparkjsdev/spark three @babylonjs/core puppeteer-core      (in a folder MODULES)
//     node viewers.mjs MODULES spark|babylon scene.ply VIEWS OUT [--frame 0] [--settings '{"blurAmount":0}'] [--browser /usr/bin/chromium]
//
// VIEWS and OUT are those of draw.mjs. --settings sets fields of Spark's renderer, or of Babylon's material.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { dirname, extname, join, resolve } from "node:path";
import { parseArgs } from "node:util";
import { readViews } from "./views.mjs";

const { positionals, values } = parseArgs({
  allowPositionals: true,
  options: {
    frame: { type: "string", default: "0" },
    settings: { type: "string", default: "{}" },
    browser: { type: "string", default: "/usr/bin/chromium" },
  },
});
const [modules, viewer, ply, viewsFile, out] = positionals;

const SPARK = `
import * as THREE from "three";
import { SparkRenderer, SplatMesh } from "@sparkjsdev/spark";
const renderer = new THREE.WebGLRenderer({ antialias: false });
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
const spark = new SparkRenderer({ renderer });
Object.assign(spark, SETTINGS);
scene.add(spark);
const splats = new SplatMesh({ url: "/scene.ply" });
splats.quaternion.set(1, 0, 0, 0);
scene.add(splats);
await splats.initialized;
const camera = new THREE.PerspectiveCamera();
window.show = ({ width, height, fy, position, ahead, up }) => {
  renderer.setSize(width, height);
  Object.assign(camera, { aspect: width / height, fov: (360 / Math.PI) * Math.atan(height / 2 / fy), near: 0.05, far: 1e5 });
  camera.position.set(...position);
  camera.up.set(...up);
  camera.lookAt(...ahead);
  camera.updateProjectionMatrix();
};
window.picture = () => {
  renderer.render(scene, camera);
  return renderer.domElement.toDataURL();
};
window.isReady = true;`;

const BABYLON = `
import { Engine } from "@babylonjs/core/Engines/engine.js";
import { Scene } from "@babylonjs/core/scene.js";
import { FreeCamera } from "@babylonjs/core/Cameras/freeCamera.js";
import { Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { GaussianSplattingMesh } from "@babylonjs/core/Meshes/GaussianSplatting/gaussianSplattingMesh.js";
const canvas = document.createElement("canvas");
document.body.append(canvas);
const engine = new Engine(canvas, false);
const scene = new Scene(engine);
scene.useRightHandedSystem = true;
const splats = new GaussianSplattingMesh("splats", null, scene);
const file = await (await fetch("/scene.ply")).arrayBuffer();
await splats.updateDataAsync(await GaussianSplattingMesh.ConvertPLYToSplatAsync(file));
splats.rotation.x = Math.PI;
Object.assign(splats.material, SETTINGS);
const camera = new FreeCamera("camera", Vector3.Zero(), scene);
window.show = ({ width, height, fy, position, ahead, up }) => {
  engine.setSize(width, height);
  Object.assign(camera, { fov: 2 * Math.atan(height / 2 / fy), minZ: 0.05, maxZ: 1e5 });
  camera.position = new Vector3(...position);
  camera.upVector = new Vector3(...up);
  camera.setTarget(new Vector3(...ahead));
};
window.picture = () => {
  scene.render();
  return canvas.toDataURL();
};
window.isReady = true;`;

const IMPORTS = {
  three: "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/",
  "@sparkjsdev/spark": "/node_modules/@sparkjsdev/spark/dist/spark.module.js",
  "@babylonjs/core/": "/node_modules/@babylonjs/core/",
};

function page() {
  const script = (viewer === "spark" ? SPARK : BABYLON).replace("SETTINGS", values.settings);
  const map = JSON.stringify({ imports: IMPORTS });
  return `<!doctype html><link rel="icon" href="data:,"><style>body{margin:0}canvas{display:block}</style><script type="importmap">${map}</script>
<body><script type="module">${script}</script>`;
}

const server = createServer((request, answer) => {
  const kinds = { ".js": "text/javascript", ".wasm": "application/wasm" };
  try {
    const path = decodeURIComponent(request.url);
    const isPage = path === "/";
    const file = path === "/scene.ply" ? ply : join(modules, path);
    const bytes = isPage ? page() : readFileSync(file);
    answer.writeHead(200, { "content-type": isPage ? "text/html" : kinds[extname(file)] ?? "application/octet-stream" });
    answer.end(bytes);
  } catch {
    answer.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));

/** A view in y-up axes, as the turned splats are. */
function seenFrom({ rows, position, ...lens }) {
  const turned = ([x, y, z]) => [x, -y, -z];
  const ahead = position.map((coordinate, axis) => coordinate + rows[2][axis]);
  return { ...lens, position: turned(position), ahead: turned(ahead), up: turned(rows[1].map((part) => -part)) };
}

const puppeteer = createRequire(resolve(modules, "node_modules", "x.js"))("puppeteer-core");
const software = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const browser = await puppeteer.launch({
  executablePath: values.browser, headless: true, args: ["--no-sandbox", ...software], protocolTimeout: 600_000,
});
try {
  const tab = await browser.newPage();
  tab.on("console", (message) => message.type() === "error" && console.error(message.text().slice(0, 300)));
  tab.on("pageerror", (error) => console.error(String(error).slice(0, 300)));
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  await tab.waitForFunction("window.isReady", { timeout: 30_000 });
  for (const view of readViews(viewsFile, Number(values.frame))) {
    await tab.setViewport({ width: view.width, height: view.height });
    await tab.evaluate((seen) => window.show(seen), seenFrom(view));
    // Splats are sorted beside the drawing: until a picture has stayed for some seconds.
    let now = "";
    for (let same = 0; same < 4; ) {
      const before = now;
      now = await tab.evaluate("picture()");
      same = now === before ? same + 1 : 0;
      await new Promise((done) => setTimeout(done, 800));
    }
    const path = join(out, view.name);
    mkdirSync(dirname(path), { recursive: true });
    writeFileSync(path, Buffer.from(now.split(",")[1], "base64"));
  }
} finally {
  await browser.close();
  server.close();
}
