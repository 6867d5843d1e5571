// What cameras saw, for the stages that look it up: the samples of a frame, each camera's in a picture of its own; and how far their lines of
// sight are free.

import { axis, carried, dot, length, place, subtract } from "./math.js";
import { VIEW_TEXELS } from "./gather.js";
import { ASKED_TEXELS, CELL_BORDER, MOST_ASKED } from "./sky.js";

/** Memory of the pictures of all cameras, at most; of more cameras the nearest are looked up, and the others show their samples as they are. */
const MOST_BYTES = 256e6;
/** Bytes of a pixel of them. */
const SEEN_BYTES = 8;

/** The cameras by their distance from a place, the nearest first. */
function nearestFirst(cameras, from) {
  const distance = (nth) => length(subtract(place(cameras[nth].world_from_camera), from));
  return cameras.map((_, nth) => nth).sort((a, b) => distance(a) - distance(b) || a - b);
}

/** The samples of a frame by camera and pixel. A view is a camera at one level; coarser levels lie beside the finest, in the same layer. */
export class SeenSamples {
  constructor(canvas, scene) {
    const { gl } = canvas;
    this.canvas = canvas;
    this.scene = scene;
    const [width, height] = [0, 1].map((side) => Math.max(...scene.cameras.map((camera) => camera.lens[side])));
    const images = scene.chunks.flat();
    const levels = Math.max(...images.map((image) => image.level));
    this.size = [levels > 0 ? width + Math.ceil(width / 2) : width, height];
    const most = Math.min(Math.floor(MOST_BYTES / (this.size[0] * this.size[1] * SEEN_BYTES)), gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS), 255);
    const count = Math.min(Math.max(most, 1), scene.cameras.length);
    this.layers = canvas.texture(gl.RG32UI, this.size, [], count);
    this.framebuffers = Array.from({ length: count }, (_, layer) => canvas.framebuffer(this.layers, null, [], layer));
    this.there = new Map();
    this.cameras = [];
    this.listed = [];
    this.all = [...new Set(images.map((image) => 4 * image.camera + image.level))].sort((a, b) => a - b);
  }

  /** The number of the view of a range of samples; 255 where it is not looked up. */
  viewOf({ camera, level }) {
    const nth = this.listed.indexOf(4 * camera + level);
    return nth < 0 || nth > 254 ? 255 : nth;
  }

  /** Brings in what is `alive` now, and takes out what no longer is. */
  *bring(alive, pose, renderer) {
    const { gl } = this.canvas;
    const most = this.framebuffers.length;
    const cameras = nearestFirst(this.scene.cameras, place(pose)).slice(0, most).sort((a, b) => a - b);
    if (cameras.join() !== this.cameras.join()) {
      this.cameras = cameras;
      this.listed = this.all.filter((view) => cameras.includes(view >> 2)).slice(0, 255);
      this.there.clear();
      for (const framebuffer of this.framebuffers) {
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
      }
    }
    const wanted = new Map(alive.filter((range) => cameras.includes(range.camera)).map((range) => [range.first, range]));
    const gone = [...this.there.values()].filter((range) => !wanted.has(range.first));
    const come = [...wanted.values()].filter((range) => !this.there.has(range.first));
    for (const [ranges, isThere] of [[gone, false], [come, true]]) {
      for (const range of ranges) {
        const stage = renderer.stage("seen");
        stage.use({}, { size: this.size, first: this.originOf(range), is_there: isThere ? 1 : 0 });
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffers[cameras.indexOf(range.camera)]);
        gl.viewport(0, 0, ...this.size);
        renderer.drawRange(range);
        if (isThere) this.there.set(range.first, range);
        else this.there.delete(range.first);
        yield;
      }
    }
  }

  /** Where a level of a camera begins in its layer. */
  originOf({ camera, level }) {
    const [width, height] = this.scene.cameras[camera].lens;
    let y = 0;
    for (let finer = 1; finer < level; finer++) y += Math.ceil(height / (1 << finer));
    return [level > 0 ? width : 0, y];
  }

  /** The rays of the first pixel of a picture, and from one column and row to the next. */
  lines(pose, lens) {
    const [a, b, c] = [0, 1, 2].map((nth) => axis(pose, nth));
    const [, , fx, fy, cx, cy] = lens;
    return {
      first_ray: c.map((part, i) => part + a[i] * (0.5 - cx) / fx + b[i] * (0.5 - cy) / fy),
      ray_across: a.map((part) => part / fx),
      ray_down: b.map((part) => part / fy),
      view_count: this.listed.length,
    };
  }

  /** The table of all views, as the stages read it. */
  views(pose, lens) {
    const [, , fx, fy, cx, cy] = lens;
    const focal = Math.sqrt(fx * fy);
    const numbers = this.listed.flatMap((view) => {
      const [nth, level] = [view >> 2, view & 3];
      const camera = this.scene.cameras[nth];
      const side = 1 << level;
      const own = camera.lens.map((part, at) => at < 2 ? Math.ceil(part / side) : part / side);
      const [there, back] = [carried(pose, lens, 1, camera.world_from_camera, own), carried(camera.world_from_camera, own, 1, pose, lens)];
      const middle = ({ corner, across, down }) => corner.map((part, i) => part + 0.5 * across[i] + 0.5 * down[i]);
      const offset = subtract(place(pose), place(camera.world_from_camera));
      const [x, y, z] = [0, 1, 2].map((at) => dot(axis(pose, at), offset));
      const ownFocal = Math.sqrt(own[2] * own[3]);
      const first = this.originOf({ camera: nth, level });
      return [
        ...middle(there), this.cameras.indexOf(nth), ...there.across, this.scene.depth_tolerance / ownFocal, ...there.down, ownFocal / focal,
        ...there.origin, own[0], ...middle(back), own[1], ...back.across, first[0], ...back.down, first[1], ...back.origin, 0,
        ...offset, 0, x * fx - z * (0.5 - cx), y * fy - z * (0.5 - cy), z, 0,
      ];
    });
    return this.table = this.canvas.table(new Float32Array(numbers), VIEW_TEXELS, this.table);
  }
}

/** How far the lines of sight of the nearest cameras are free. */
export class FreeSpace {
  constructor(canvas, scene, unit) {
    const { gl } = canvas;
    Object.assign(this, { canvas, scene, unit, cameras: [], key: null });
    const count = Math.min(MOST_ASKED, scene.cameras.length);
    this.size = [0, 1].map((side) => Math.ceil(Math.max(...scene.cameras.map((camera) => camera.lens[side])) / 2) + 2 * CELL_BORDER);
    const [cells, free] = [gl.DEPTH_COMPONENT32F, gl.R32UI].map((format) => canvas.texture(format, this.size, [], count));
    Object.assign(this, { cells, free });
    this.targets = Array.from({ length: count }, (_, layer) => ({
      cells: canvas.framebuffer(null, cells, [], layer),
      free: { framebuffer: canvas.framebuffer(free, null, [], layer), size: this.size },
    }));
  }

  /** A camera of cells of 2×2 pixels. */
  cellLens(camera) {
    return this.scene.cameras[camera].lens.map((part, at) => at < 2 ? Math.ceil(part / 2) : part / 2);
  }

  /** Takes in what cameras saw at a frame. */
  *see(alive, pose, renderer) {
    const { gl } = this.canvas;
    const cameras = nearestFirst(this.scene.cameras, place(pose)).slice(0, this.targets.length);
    const key = [cameras, alive.map((range) => range.first)].join();
    if (key === this.key) return;
    const [cell, free] = [renderer.stage("cell"), renderer.stage("free")];
    for (const [layer, camera] of cameras.entries()) {
      const lens = this.cellLens(camera);
      const size = [lens[0] + 2 * CELL_BORDER, lens[1] + 2 * CELL_BORDER];
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets[layer].cells);
      gl.clearDepth(0);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      for (const range of alive) {
        const { lens: from, world_from_camera: at } = this.scene.cameras[range.camera];
        cell.use({}, { ...carried(at, from, 1 << range.level, this.scene.cameras[camera].world_from_camera, lens), unit: this.unit, size, pixel_scale: 1 });
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets[layer].cells);
        gl.viewport(0, 0, ...size);
        gl.enable(gl.DEPTH_TEST);
        gl.depthFunc(gl.GREATER);
        renderer.drawRange(range);
        gl.disable(gl.DEPTH_TEST);
      }
      free.use({ cells: this.cells }, { layer, unit: this.unit });
      this.canvas.over(this.targets[layer].free);
      yield;
    }
    Object.assign(this, { cameras, key });
  }

  /** The table of the cameras, as the stages read it. */
  asked(pose, lens) {
    const numbers = this.cameras.flatMap((camera) => {
      const cells = this.cellLens(camera);
      const { corner, across, down, origin } = carried(pose, lens, 1, this.scene.cameras[camera].world_from_camera, cells);
      const middle = corner.map((part, i) => part + 0.5 * across[i] + 0.5 * down[i]);
      const behind = 1 - 1 / Math.sqrt(cells[2] * cells[3]);
      const last = [cells[0] + 2 * CELL_BORDER - 2, cells[1] + 2 * CELL_BORDER - 2];
      return [...middle, behind, ...across, last[0], ...down, last[1], ...origin, 0];
    });
    return this.table = this.canvas.table(new Float32Array(numbers), ASKED_TEXELS, this.table);
  }
}
