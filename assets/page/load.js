// Brings the samples from the file to the renderer.

import { bytesOfBase64, inflate, skyColors } from "./decode.js";
import { Decoders } from "./decoders.js";
import { Renderer } from "./renderer.js";
import { homeDistance } from "./view.js";

/** A hidden page draws no picture; its samples wait this many milliseconds for one. */
const PATIENCE = 1000;

const progressBar = () => document.getElementById("progress");

/** Decodes all chunks, those of the current frame first, as they arrive; until the player loads anew. */
export async function load(player) {
  const own = player.loading = {};
  player.decoded.clear();
  progressBar().hidden = false;
  const { chunks } = player.scene;
  const counts = chunks.map((images) => images.reduce((sum, image) => sum + image.samples, 0));
  const firsts = counts.map((_, nth) => counts.slice(0, nth).reduce((sum, count) => sum + count, 0));
  const decoders = new Decoders();
  const running = new Map();
  while (player.loading === own && player.decoded.size < chunks.length) {
    const next = nextChunk(player, running);
    if (next !== undefined && running.size < decoders.count) {
      running.set(next.nth, decoders.decode(next.text, chunks[next.nth], player.scene.cameras).then((decoded) => [next.nth, decoded]));
      // The first chunk is decoded while the browser makes ready to draw.
      await prepareToDraw(player);
      continue;
    }
    const isArriving = document.readyState === "loading" && next === undefined;
    if (!isArriving && running.size === 0) throw new Error("the file is cut short");
    const done = await Promise.race([...running.values(), ...isArriving ? [after(20)] : []]);
    if (player.loading !== own || done === undefined) continue;
    const [nth, decoded] = done;
    running.delete(nth);
    player.renderer.upload(decoded, chunks[nth], firsts[nth]);
    await took(player, nth);
    // What finer pictures need is made after the first picture.
    if (player.pictures > 0) player.renderer?.makeReady();
  }
  decoders.end();
  if (player.loading !== own) return;
  await prepareToDraw(player);
  await player.renderer.makeReady();
  if (player.loading !== own) return;
  player.wake();
  player.loading = null;
  progressBar().hidden = true;
  document.documentElement.dataset.loaded = String(Math.round(performance.now()));
}

/** The chunk to decode next and its text, of those that are there and not among those `running`. */
function nextChunk(player, running) {
  const there = document.getElementsByClassName("chunk");
  // The last one may still be on its way.
  const whole = document.readyState === "loading" ? there.length - 1 : there.length;
  const isWaiting = (nth) => nth < whole && !player.decoded.has(nth) && !running.has(nth);
  const nth = player.missing().find(isWaiting) ?? player.scene.chunks.findIndex((_, at) => isWaiting(at));
  return nth < 0 ? undefined : { nth, text: there[nth].textContent };
}

/** Makes the renderer, once. */
async function prepareToDraw(player) {
  if (player.renderer) return;
  const { scene } = player;
  const renderer = player.renderer = new Renderer(player.canvas, scene, homeDistance(scene));
  if (scene.sky) renderer.uploadSky(skyColors(await inflate(bytesOfBase64(scene.sky.colors))), scene.sky.rows);
}

/** Shows what a chunk adds. Pictures and people come before the next chunk, the first picture above all; a hidden page draws none. */
async function took(player, nth) {
  player.decoded.add(nth);
  const percent = Math.round(100 * player.decoded.size / player.scene.chunks.length);
  progressBar().setAttribute("aria-valuenow", String(percent));
  progressBar().firstElementChild.style.width = `${percent}%`;
  player.wake();
  const isFirstDue = player.pictures === 0 && player.isPartTime();
  await (isFirstDue ? Promise.race([new Promise(requestAnimationFrame), after(PATIENCE)]) : after(0));
}

/** Resolves to nothing after some milliseconds. */
function after(milliseconds) {
  return new Promise((resolve) => { setTimeout(resolve, milliseconds); });
}
