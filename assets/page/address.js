// The view as the fragment of an address, and back:
//
//   #view=x,y,z,qx,qy,qz,qw,distance&frame=number[&lens=width,height,fx,fy,cx,cy][&camera=name][&bare]
//
// x, y, z is the place in world space; the quaternion turns camera space (x right, y down, z forward) into world space; `distance` is
// how far ahead the pivot of orbiting is. `lens` is left out where it is that of the first camera. `camera` stands for the view of a
// camera. `bare` shows the picture alone, for a page within a page.

import { place, poseFrom, quaternionOf } from "./math.js";

/** As many digits as tell a picture from the next. */
const short = (number) => String(Number(number.toPrecision(9)));

/** The numbers of poses that were read or written, as text: an address that is opened again stays the same. */
const written = new WeakMap();

const read = (numbers) => {
  const size = Math.hypot(...numbers.slice(3, 7));
  return size > 0.5 ? poseFrom(numbers.slice(3, 7).map((part) => part / size), numbers.slice(0, 3)) : null;
};

/** Rounds the pose of a view to what its address says, so that the address shows the very same picture. */
export function roundView(view) {
  if (written.has(view.pose)) return;
  const text = [...place(view.pose), ...quaternionOf(view.pose)].map(short);
  view.pose = read(text.map(Number)) ?? view.pose;
  written.set(view.pose, text);
}

export function fragmentOf(view, scene, frameNumber, isBare) {
  const numbers = [...written.get(view.pose) ?? [...place(view.pose), ...quaternionOf(view.pose)].map(short), short(view.pivotDistance)];
  const isUsual = view.lens.every((part, nth) => part === scene.cameras[0].lens[nth]);
  const lens = isUsual ? "" : `&lens=${view.lens.map(short).join(",")}`;
  return `#view=${numbers.join(",")}&frame=${frameNumber}${lens}${isBare ? "&bare" : ""}`;
}

const numbersOf = (text, count) => {
  const numbers = (text ?? "").split(",").map(Number);
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
};

/** What a fragment says; parts that say nothing sensible are left out. */
export function readFragment(fragment, scene) {
  const fields = new URLSearchParams(fragment.replace(/^#/, "").replaceAll("+", "%2B"));
  const found = { isBare: fields.has("bare") };
  const camera = scene.cameras.find((one) => one.name === fields.get("camera"));
  if (camera) [found.pose, found.lens] = [camera.world_from_camera, camera.lens];
  const view = numbersOf(fields.get("view"), 8);
  const pose = view && view[7] > 0 ? read(view) : null;
  if (pose) {
    found.pose = pose;
    written.set(pose, fields.get("view").split(",").slice(0, 7));
    found.pivotDistance = view[7];
    found.lens = scene.cameras[0].lens;
  }
  const lens = numbersOf(fields.get("lens"), 6);
  if (lens && lens.slice(0, 4).every((part) => part > 0)) found.lens = lens;
  const number = numbersOf(fields.get("frame"), 1);
  if (number) {
    const index = scene.frames.findIndex((frame) => frame >= number[0]);
    found.frame = index < 0 ? scene.frames.length - 1 : index;
  }
  return found;
}
