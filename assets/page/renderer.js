// Draws samples into a canvas by WebGL2. All samples lie in one buffer, image after image; a frame is drawn from those whose span it is in.

import { axis, carried, inPixels } from "./math.js";
import { SAMPLE_BYTES } from "./decode.js";
import { SEEN_FRAGMENT, SEEN_VERTEX, SURFACE_FRAGMENT, SURFACE_VERTEX, WHOLE_VERTEX } from "./shaders.js";
import { GATHER, NEAREST, SILHOUETTE } from "./gather.js";
import { FILL, MOST_LEVELS, PULL, ROWS, SHOW } from "./fill.js";
import { AROUND, CELL_FRAGMENT, CELL_VERTEX, FREE, LINES, MARK, SQUARE, SQUARES } from "./sky.js";
import { Canvas, CannotDraw } from "./canvas.js";
import { FreeSpace, SeenSamples } from "./seen.js";

/** Footprints whose centers lie this far outside the picture are drawn too, pixels. */
const GUARD = 64;

/** Samples of spans of at least this share of all frames are drawn once while the view is still. */
const LASTING = 0.25;

/** Samples, and pixels, that are drawn at a time while somebody may want something else. */
const [SAMPLES_AT_A_TIME, PIXELS_AT_A_TIME] = [200000, 100000];

/** The programs of all stages, by name: two texts each, or the second one alone where it is drawn over a whole picture. */
const PROGRAMS = {
  surface: [SURFACE_VERTEX, SURFACE_FRAGMENT], seen: [SEEN_VERTEX, SEEN_FRAGMENT], cell: [CELL_VERTEX, CELL_FRAGMENT],
  nearest: NEAREST, silhouette1: SILHOUETTE(1), gather1: GATHER(1), silhouette2: SILHOUETTE(2), gather2: GATHER(2),
  free: FREE, squares: SQUARES, around: AROUND, lines: LINES, mark: MARK, pull: PULL, rows: ROWS, show: SHOW,
  fill: FILL(false), fill_round: FILL(true),
};

export class Renderer {
  /** `scene` is the header of the page; `unit` a typical distance in it. */
  constructor(canvas, scene, unit) {
    this.canvas = new Canvas(canvas);
    this.scene = scene;
    this.unit = unit;
    this.ranges = [];
    this.stages = new Map();
    for (const name of ["surface", "nearest", "pull", "fill", "rows", "show"]) this.stage(name);
    this.isReady = false;
    this.sky = null;
    /** Those of pictures in motion and at rest: the picture that is shown stays while another is drawn. */
    this.targetsOf = { motion: null, rest: null };
    this.targets = null;
    this.shown = null;
    this.allocate();
    this.seen = new SeenSamples(this.canvas, scene);
    this.freeSpace = scene.sky ? new FreeSpace(this.canvas, scene, unit) : null;
  }

  /** A stage by its name. */
  stage(name) {
    if (!this.stages.has(name)) this.stages.set(name, this.canvas.stage(...typeof PROGRAMS[name] === "string" ? [WHOLE_VERTEX, PROGRAMS[name]] : PROGRAMS[name]));
    return this.stages.get(name);
  }

  /** Has the driver make what fine pictures need; whoever draws one sooner is held up until it is there. */
  makeReady() {
    const wait = async () => {
      Object.keys(PROGRAMS).forEach((name) => this.stage(name));
      while (![...this.stages.values()].every((stage) => stage.isMade())) await new Promise((resolve) => { setTimeout(resolve, 20); });
      this.isReady = true;
    };
    return this.beingMade ??= wait();
  }

  /** Makes room for all samples. */
  allocate() {
    const { gl } = this.canvas;
    const count = this.scene.chunks.flat().reduce((sum, image) => sum + image.samples, 0);
    this.samples = gl.createVertexArray();
    this.buffer = gl.createBuffer();
    gl.bindVertexArray(this.samples);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, count * SAMPLE_BYTES, gl.STATIC_DRAW);
    if (gl.getError() === gl.OUT_OF_MEMORY) {
      throw new CannotDraw("The scene is too large for the memory of this device. A page made with a smaller --at-most will fit.");
    }
    const attributes = [[2, gl.UNSIGNED_SHORT, false, 0], [1, gl.FLOAT, false, 4], [2, gl.SHORT, true, 8], [4, gl.UNSIGNED_BYTE, true, 12]];
    attributes.forEach(([parts, type, normalized, offset], location) => {
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, parts, type, normalized, SAMPLE_BYTES, offset);
    });
    gl.bindVertexArray(null);
  }

  /** Takes the samples of some images as `decodeChunk` gives them, which begin at sample `first` of all. */
  upload({ samples, counts }, images, first) {
    const { gl } = this.canvas;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, first * SAMPLE_BYTES, samples);
    images.forEach((image, nth) => {
      this.ranges.push({ ...image, first, counts: counts[nth] });
      first += image.samples;
    });
    // Ranges of one camera are drawn together.
    this.ranges.sort((a, b) => a.camera - b.camera || a.level - b.level || a.first - b.first);
  }

  /** Takes the map of the sky: 8-bit sRGB, twice as many columns as rows. */
  uploadSky(colors, rows) {
    const { gl } = this.canvas;
    this.sky = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.sky);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 2 * rows, rows, 0, gl.RGB, gl.UNSIGNED_BYTE, colors);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  }

  /** Draws a picture at once, as `steps` does. */
  draw(...picture) {
    for (const step of this.steps(...picture)) void step;
  }

  /**
   * Draws a frame, by its index, from a pose through a lens, whose size is that of the picture, step by step; the last one shows it. Of 2×2
   * samples one is drawn if `coarser` is 1, of 4×4 if it is 2. With two `subpixels` silhouettes are as fine as half a pixel. Where only
   * time passes, as `isStill` says, the nearest of the samples that last are found once.
   */
  *steps(frame, pose, lens, { isStill = false, coarser = 0, subpixels = 1, isFinal = false } = {}) {
    const { scene } = this;
    const alive = this.ranges.filter((range) => range.start <= frame && frame < range.end);
    this.takeSize(lens, subpixels, isFinal);
    const { targets } = this;
    const fine = inPixels(lens, subpixels);
    const picture = { pose, lens, fine, subpixels, coarser, isFinal };
    if (coarser === 0) yield* this.seen.bring(alive, pose, this);
    if (isStill) {
      const lasts = (range) => range.end - range.start >= scene.frames.length * LASTING;
      const key = [coarser, ...pose, ...lens, ...alive.filter(lasts).map((range) => range.first)].join();
      if (key !== targets.lastingKey) yield* this.findSurface(targets.lasting, alive.filter(lasts), picture);
      targets.lastingKey = key;
      yield* this.findSurface(targets.nearest, alive.filter((range) => !lasts(range)), picture, targets.lasting);
    } else {
      yield* this.findSurface(targets.nearest, alive, picture);
    }
    yield* this.gather(picture);
    if (this.freeSpace) {
      // In motion what cameras saw a moment ago is true enough.
      if (isFinal || this.freeSpace.key === null) yield* this.freeSpace.see(alive, pose, this);
      yield* this.markHoles(picture);
    }
    yield* this.fill(picture);
    this.show(picture);
  }

  /** The nearest depth in each pixel, and the color and the view there; over those of `before`, if it is given. */
  *findSurface(target, alive, { pose, fine, coarser }, before) {
    const { gl } = this.canvas;
    const [width, height] = fine;
    const stage = this.stage("surface");
    const begin = () => {
      gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
      gl.viewport(-GUARD, -GUARD, width + 2 * GUARD, height + 2 * GUARD);
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.GREATER);
      stage.use();
      stage.numbers({ guard: GUARD, unit: this.unit, pixel_scale: 1 / (1 << coarser), size: [width, height] });
    };
    begin();
    if (before) {
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, before.framebuffer);
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.DEPTH_BUFFER_BIT | gl.COLOR_BUFFER_BIT, gl.NEAREST);
    } else {
      gl.clearDepth(0);
      gl.clear(gl.DEPTH_BUFFER_BIT);
    }
    let drawn = 0;
    for (const range of alive) {
      const { lens: from, world_from_camera: place } = this.scene.cameras[range.camera];
      const side = 1 << range.level + coarser;
      stage.numbers({
        ...carried(place, from, side, pose, fine),
        view: this.seen.viewOf(range),
        focal_ratio: side * Math.sqrt(fine[2] * fine[3] / (from[2] * from[3])),
        per_footprint: side / Math.sqrt(from[2] * from[3]),
      });
      drawn += this.drawRange(range, coarser);
      if (drawn < SAMPLES_AT_A_TIME) continue;
      drawn = 0;
      gl.disable(gl.DEPTH_TEST);
      yield;
      begin();
    }
    gl.disable(gl.DEPTH_TEST);
  }

  /** Draws the samples of a range as points; gives how many. */
  drawRange({ first, counts }, coarser = 0) {
    const { gl } = this.canvas;
    gl.bindVertexArray(this.samples);
    gl.drawArrays(gl.POINTS, first, counts[2 - coarser]);
    return counts[2 - coarser];
  }

  /** What each pixel shows. */
  *gather({ pose, lens, fine, subpixels, coarser }) {
    const { targets, seen } = this;
    const { nearest, surfaces, picture } = targets;
    if (coarser > 0) {
      this.stage("nearest").use({ depths: nearest.depths, own: nearest.own }, { unit: this.unit });
      this.canvas.over(picture);
      return;
    }
    const [silhouette, gather] = ["silhouette", "gather"].map((name) => this.stage(name + subpixels));
    const numbers = { ...seen.lines(pose, fine), unit: this.unit, surface_ratio: 1 / (1 + this.scene.depth_tolerance / Math.sqrt(fine[2] * fine[3])) };
    const views = seen.views(pose, fine);
    const textures = { views, seen: seen.layers, depths: nearest.depths };
    yield* this.inBands(surfaces, fine, () => silhouette.use(textures, numbers));
    yield* this.inBands(picture, lens, () => gather.use({ ...textures, surfaces: surfaces.texture, own: nearest.own }, numbers));
  }

  /** Which pixels are holes, and of what kinds, where there is a sky. */
  *markHoles({ pose, lens, isFinal }) {
    const [squares, around, lines, mark] = ["squares", "around", "lines", "mark"].map((name) => this.stage(name));
    const { targets, freeSpace } = this;
    const picture = targets.picture.texture;
    squares.use({ picture });
    this.canvas.over(targets.squares);
    around.use({ squares: targets.squares.texture });
    this.canvas.over(targets.around);
    const [asked, numbers] = [freeSpace.asked(pose, lens), { asked_count: freeSpace.cameras.length, depth_count: isFinal ? 64 : 16 }];
    const textures = { picture, around: targets.around.texture, asked, free: freeSpace.free };
    yield* this.inBands(targets.lines, lens, () => lines.use(textures, numbers));
    yield* this.inBands(targets.marked, lens, () => mark.use({ ...textures, lines: targets.lines.texture }, numbers));
  }

  /** What fills holes. */
  *fill({ pose, lens, isFinal }) {
    const [pull, rows] = ["pull", "rows"].map((name) => this.stage(name));
    const { targets, freeSpace } = this;
    const numbers = { has_sky: Boolean(this.sky), footprints: this.scene.depth_tolerance, focal: Math.sqrt(lens[2] * lens[3]), levels: targets.places };
    const marked = this.marked();
    targets.places.forEach(([x, y, width, height], nth) => {
      const [to, from] = nth % 2 === 0 ? [targets.odd, targets.even] : [targets.even, targets.odd];
      // What is drawn into must not be bound, even where it is not read.
      pull.use({ marked, odd_levels: from.texture, even_levels: from.texture }, { ...numbers, level: nth + 1, first: [x, y] });
      this.canvas.over(to, [x, y, width, height]);
    });
    const textures = { marked, odd_levels: targets.odd.texture, even_levels: targets.even.texture };
    Object.assign(numbers, { level_count: targets.places.length });
    // In motion what is invented may be simpler.
    if (freeSpace && isFinal) {
      Object.assign(textures, { asked: freeSpace.asked(pose, lens), free: freeSpace.free });
      Object.assign(numbers, this.seen.lines(pose, lens), { asked_count: freeSpace.cameras.length });
    }
    const fill = this.stage(freeSpace && isFinal ? "fill_round" : "fill");
    yield* this.inBands(targets.fillings, lens, () => fill.use(textures, numbers));
    yield* this.inBands(targets.sums, lens, () => rows.use({ fillings: targets.fillings.texture }));
  }

  /** The picture with its holes. */
  marked() {
    return (this.freeSpace ? this.targets.marked : this.targets.picture).texture;
  }

  show({ pose, lens }) {
    const { targets, canvas } = this;
    canvas.resize(lens);
    const numbers = { has_sky: Boolean(this.sky), ...skyLines(pose, lens) };
    this.stage("show").use({ marked: this.marked(), fillings: targets.fillings.texture, sums: targets.sums.texture, sky: this.sky }, numbers);
    canvas.over({ framebuffer: null, size: lens });
    this.shown = { targets, target: this.freeSpace ? targets.marked : targets.picture, size: lens };
  }

  /** Draws over the whole of a target, in bands of rows; `begin` takes a stage into use. */
  *inBands(target, [width, height], begin) {
    const rows = Math.max(Math.ceil(PIXELS_AT_A_TIME / width), 1);
    for (let row = 0; row < height; row += rows) {
      begin();
      this.canvas.over(target, [0, row, width, Math.min(rows, height - row)]);
      yield;
    }
  }

  /** The inverse depth in a pixel of the last picture, counted from its upper left corner; 0 at infinity and in holes. */
  inverseDepthAt(x, y) {
    if (!this.shown) return 0;
    const { target, size } = this.shown;
    const inside = [x, y].map((part, nth) => Math.min(Math.max(Math.floor(part), 0), size[nth] - 1));
    return Math.max(this.canvas.floatAt(target, inside, 2), 0);
  }

  /** Takes the targets of a picture of a size, and makes them where they had another one. */
  takeSize([width, height], subpixels, isFinal) {
    const { canvas } = this;
    const { gl } = canvas;
    const name = isFinal ? "rest" : "motion";
    const key = [width, height, subpixels].join();
    this.targets = this.targetsOf[name];
    if (this.targets?.key === key) return;
    canvas.forget(this.targets?.made ?? []);
    if (this.shown?.targets === this.targets) this.shown = null;
    const made = [];
    const size = [width, height];
    const four = (of) => canvas.target(gl.RGBA32UI, of, made);
    const two = (of) => canvas.target(gl.RG32UI, of, made);
    const fine = size.map((side) => side * subpixels);
    const nearest = () => canvas.nearestTarget(fine, made);
    const [places, sizes] = levelPlaces(size);
    this.targets = this.targetsOf[name] = {
      key, made, nearest: nearest(), lasting: isFinal ? null : nearest(), surfaces: four(fine), picture: four(size), fillings: four(size), sums: four(size),
      places, odd: four(sizes[0]), even: four(sizes[1]), lastingKey: null,
    };
    if (this.freeSpace) {
      const squares = size.map((side) => Math.ceil(side / SQUARE));
      Object.assign(this.targets, { squares: two(squares), around: two(squares), lines: two(size), marked: four(size) });
    }
  }
}

/** Directions of the corner of a picture, and from one column and row to the next, in world space. */
function skyLines(pose, lens) {
  const [a, b, c] = [0, 1, 2].map((nth) => axis(pose, nth));
  return {
    sky_corner: c.map((part, i) => part - a[i] * lens[4] / lens[2] - b[i] * lens[5] / lens[3]),
    sky_across: a.map((part) => part / lens[2]),
    sky_down: b.map((part) => part / lens[3]),
  };
}

/** Where the levels of a picture lie in two textures, odd and even ones, and the sizes of these. */
function levelPlaces(size) {
  const places = [];
  const sizes = [[1, 1], [1, 1]];
  const free = [[0, 0], [0, 0]];
  let [width, height] = size;
  do {
    [width, height] = [Math.ceil(width / 2), Math.ceil(height / 2)];
    const which = places.length % 2;
    const [x, y] = free[which];
    places.push([x, y, width, height]);
    sizes[which] = [Math.max(sizes[which][0], x + width), Math.max(sizes[which][1], y + height)];
    free[which] = places.length < 3 ? [width, 0] : [x, y + height];
  } while (places.length < MOST_LEVELS && Math.max(width, height) > 1);
  return [places, sizes];
}
