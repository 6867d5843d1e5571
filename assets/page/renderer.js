// Draws samples into a canvas by WebGL2. All samples lie in one buffer, image after image; a frame is drawn from those whose span it is in.

import { axis, place, subtract, turnedBack } from "./math.js";
import { SAMPLE_BYTES } from "./decode.js";
import {
  BLEND_FRAGMENT, BLEND_VERTEX, CARRY, FILL, PULL_LEVEL, PULL_PICTURE, PUSH_LEVEL, SHOW, SURFACE_FRAGMENT, SURFACE_VERTEX,
  TURN_OVER, WHOLE_VERTEX,
} from "./shaders.js";

/** Footprints whose centers lie this far outside the picture are drawn too, pixels. */
const GUARD = 64;

/** Levels that holes are filled from, at most: holes of that many doublings of a pixel. */
const MOST_LEVELS = 9;

/** Samples of spans of at least this share of all frames are drawn once while the view is still. */
const LASTING = 0.25;

/** The depth of the sky in the buffer. */
const SKY_DEPTH = 0.5;

/** In the open, at least this share of what cameras saw is sky: where nothing is known, there is sky. */
const OPEN = 0.2;

/** A reason, in words for people, for which nothing can be drawn. */
export class CannotDraw extends Error {}

export class Renderer {
  /** `scene` is the header of the page; `unit` a typical distance in it. */
  constructor(canvas, scene, unit) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, powerPreference: "high-performance" });
    if (!gl) throw new CannotDraw("This browser has no WebGL2, which draws the scene. Another browser, or a newer one, will show it.");
    const hasFloats = gl.getExtension("EXT_color_buffer_float") || gl.getExtension("EXT_color_buffer_half_float");
    if (!hasFloats) throw new CannotDraw("This device cannot blend colors precisely enough to draw the scene. Another one will show it.");
    this.gl = gl;
    this.scene = scene;
    this.unit = unit;
    this.size = [0, 0];
    this.ranges = [];
    this.programs = {
      surface: new Stage(gl, SURFACE_VERTEX, SURFACE_FRAGMENT),
      blend: new Stage(gl, BLEND_VERTEX, BLEND_FRAGMENT),
      pullPicture: new Stage(gl, WHOLE_VERTEX, PULL_PICTURE),
      pullLevel: new Stage(gl, WHOLE_VERTEX, PULL_LEVEL),
      pushLevel: new Stage(gl, WHOLE_VERTEX, PUSH_LEVEL),
      carry: new Stage(gl, WHOLE_VERTEX, CARRY),
      show: new Stage(gl, WHOLE_VERTEX, SHOW),
      fill: new Stage(gl, WHOLE_VERTEX, FILL),
      turnOver: new Stage(gl, WHOLE_VERTEX, TURN_OVER),
    };
    this.nothing = gl.createVertexArray();
    this.sky = null;
    this.targets = null;
    this.allocate();
  }

  /** Makes room for all samples. */
  allocate() {
    const gl = this.gl;
    const count = this.scene.chunks.flat().reduce((sum, image) => sum + image.samples, 0);
    this.samples = gl.createVertexArray();
    this.buffer = gl.createBuffer();
    gl.bindVertexArray(this.samples);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, count * SAMPLE_BYTES, gl.STATIC_DRAW);
    if (gl.getError() !== gl.NO_ERROR) {
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
    const gl = this.gl;
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
    const gl = this.gl;
    this.sky = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.sky);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 2 * rows, rows, 0, gl.RGB, gl.UNSIGNED_BYTE, colors);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  }

  /**
   * Draws a frame, by its index, from a pose through a lens, whose size is that of the picture. Where only time passes, as `isStill` says,
   * samples that last are drawn once, and those that come and go over them. Of 2×2 samples one is drawn if `coarser` is 1, of 4×4 if it is 2.
   */
  draw(frame, pose, lens, isStill = false, coarser = 0) {
    this.coarser = coarser;
    const gl = this.gl;
    const [width, height] = lens;
    if (this.size[0] !== width || this.size[1] !== height) this.resize(width, height);
    const { targets } = this;
    const alive = this.ranges.filter((range) => range.start <= frame && frame < range.end);
    if (isStill) {
      const lasts = (range) => range.end - range.start >= this.scene.frames.length * LASTING;
      const key = [coarser, ...pose, ...lens, ...alive.filter(lasts).map((range) => range.first)].join();
      if (key !== targets.lastingKey) this.drawPicture(targets.lasting, alive.filter(lasts), pose, lens);
      targets.lastingKey = key;
      this.drawPicture(targets.whole, alive.filter((range) => !lasts(range)), pose, lens, targets.lasting);
    } else {
      this.drawPicture(targets.whole, alive, pose, lens);
    }
    this.fillLevels();
    this.finish(pose, lens);
  }

  /** Depths and sums of colors; over those of a picture `before`, if one is given. */
  drawPicture(target, alive, pose, lens, before) {
    this.drawSurface(target.surface, alive, pose, lens, before?.surface);
    if (this.coarser === 0) this.drawBlend(target, alive, pose, lens, before);
  }

  /** The nearest depth in each pixel and the color there, over those of a picture `before`, if one is given. */
  drawSurface(framebuffer, alive, pose, lens, before) {
    const gl = this.gl;
    const [width, height] = this.size;
    const planes = gl.DEPTH_BUFFER_BIT | gl.COLOR_BUFFER_BIT;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(-GUARD, -GUARD, width + 2 * GUARD, height + 2 * GUARD);
    gl.depthMask(true);
    if (before) {
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, before);
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, planes, gl.NEAREST);
    } else {
      gl.clearDepth(0);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(planes);
    }
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.GREATER);
    this.drawSamples(this.programs.surface, alive, pose, lens);
    gl.disable(gl.DEPTH_TEST);
  }

  /** The sums of colors and weights in each pixel; with those of a picture `before`, if one is given. */
  drawBlend(target, alive, pose, lens, before) {
    const gl = this.gl;
    const ratio = 1 / (1 + this.scene.depth_tolerance / Math.sqrt(lens[2] * lens[3]));
    const { carry, blend } = this.programs;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blended);
    if (before) {
      carry.use();
      bind(gl, carry, { lasting_sums: before.sums, lasting_depths: before.depths, depths: target.depths });
      gl.uniform1f(carry.uniform("surface_ratio"), ratio);
      gl.uniform1f(carry.uniform("unit"), this.unit);
      this.over(target.blended, this.size);
    }
    gl.viewport(-GUARD, -GUARD, this.size[0] + 2 * GUARD, this.size[1] + 2 * GUARD);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    blend.use();
    bind(gl, blend, { depths: target.depths });
    gl.uniform4f(blend.uniform("lens"), lens[2], lens[3], lens[4], lens[5]);
    gl.uniform1f(blend.uniform("surface_ratio"), ratio);
    this.drawSamples(blend, alive, pose, lens);
    gl.disable(gl.BLEND);
  }

  drawSamples(stage, alive, pose, lens) {
    const gl = this.gl;
    gl.bindVertexArray(this.samples);
    stage.use();
    gl.uniform1f(stage.uniform("guard"), GUARD);
    gl.uniform2f(stage.uniform("size"), lens[0], lens[1]);
    gl.uniform1f(stage.uniform("unit"), this.unit);
    gl.uniform1f(stage.uniform("pixel_scale"), 1 / (1 << this.coarser));
    alive.forEach(({ camera, level, first, counts }, nth) => {
      if (nth === 0 || alive[nth - 1].camera !== camera || alive[nth - 1].level !== level) {
        this.setCamera(stage, this.scene.cameras[camera], 1 << level + this.coarser, pose, lens);
      }
      gl.drawArrays(gl.POINTS, first, counts[2 - this.coarser]);
    });
  }

  /** Carries pixels of a camera, `side` of its pixels wide, into the picture: `ray·z` and the way between the cameras, before the division. */
  setCamera(stage, camera, side, pose, lens) {
    const gl = this.gl;
    const from = camera.world_from_camera;
    const [, , fx, fy, cx, cy] = camera.lens;
    const inPicture = (v) => {
      const [x, y, z] = turnedBack(pose, v);
      return [lens[2] * x + lens[4] * z, lens[3] * y + lens[5] * z, z];
    };
    const [a, b, c] = [0, 1, 2].map((nth) => inPicture(axis(from, nth)));
    gl.uniform3fv(stage.uniform("corner"), [0, 1, 2].map((i) => c[i] - a[i] * cx / fx - b[i] * cy / fy));
    gl.uniform3fv(stage.uniform("across"), a.map((part) => part * side / fx));
    gl.uniform3fv(stage.uniform("down"), b.map((part) => part * side / fy));
    gl.uniform3fv(stage.uniform("origin"), inPicture(subtract(place(from), place(pose))));
    gl.uniform1f(stage.uniform("focal_ratio"), side * Math.sqrt(lens[2] * lens[3] / (fx * fy)));
    gl.uniform1f(stage.uniform("per_footprint"), side / Math.sqrt(fx * fy));
  }

  /** What holes are filled with, level by level. */
  fillLevels() {
    const gl = this.gl;
    const { pulled, pushed, whole } = this.targets;
    const { pullPicture, pullLevel, pushLevel } = this.programs;
    pulled.forEach((level, nth) => {
      const stage = nth === 0 ? pullPicture : pullLevel;
      const size = nth === 0 ? this.size : pulled[nth - 1].size;
      stage.use();
      bind(gl, stage, nth === 0 ? { sums: whole.sums, depths: whole.depths } : { level: pulled[nth - 1].color });
      gl.uniform2i(stage.uniform("last"), size[0] - 1, size[1] - 1);
      this.over(level.framebuffer, level.size);
    });
    pushLevel.use();
    for (let nth = pushed.length - 1; nth >= 0; nth--) {
      bind(gl, pushLevel, { level: pulled[nth].color, coarser: (pushed[nth + 1] ?? pulled[nth + 1]).color });
      this.over(pushed[nth].framebuffer, pushed[nth].size);
    }
  }

  finish(pose, lens) {
    const gl = this.gl;
    const { targets } = this;
    const { show, fill, turnOver } = this.programs;
    show.use();
    bind(gl, show, { sums: targets.whole.sums });
    this.over(targets.shown, this.size);
    // A hole is where the depth is that of nothing.
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.EQUAL);
    gl.depthMask(false);
    const [a, b, c] = [axis(pose, 0), axis(pose, 1), axis(pose, 2)];
    fill.use();
    bind(gl, fill, { coarser: (targets.pushed[0] ?? targets.pulled[0]).color, level: targets.pulled[0].color, sky: this.sky });
    gl.uniform1i(fill.uniform("has_sky"), this.sky ? 1 : 0);
    gl.uniform1i(fill.uniform("is_open"), this.sky && this.scene.sky.share >= OPEN ? 1 : 0);
    gl.uniform3fv(fill.uniform("sky_corner"), c.map((part, i) => part - a[i] * lens[4] / lens[2] - b[i] * lens[5] / lens[3]));
    gl.uniform3fv(fill.uniform("sky_across"), a.map((part) => part / lens[2]));
    gl.uniform3fv(fill.uniform("sky_down"), b.map((part) => part / lens[3]));
    for (const [isSky, depth] of [[0, 0], [1, SKY_DEPTH]]) {
      gl.uniform1i(fill.uniform("is_sky"), isSky);
      gl.uniform1f(fill.uniform("depth"), depth);
      this.over(targets.shown, this.size);
    }
    gl.disable(gl.DEPTH_TEST);
    gl.depthMask(true);
    turnOver.use();
    bind(gl, turnOver, { picture: targets.picture });
    this.over(null, this.size);
  }

  /** Draws one triangle over the whole of a target. */
  over(framebuffer, [width, height]) {
    const gl = this.gl;
    gl.bindVertexArray(this.nothing);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The inverse depth in the middle of a pixel of the last picture, counted from its upper left corner; 0 at infinity and in holes. */
  inverseDepthAt(x, y) {
    const gl = this.gl;
    if (!this.targets) return 0;
    // Depth cannot be read directly: it is copied into the bytes of a color of one pixel.
    const stage = this.programs.depthAt ??= new Stage(gl, WHOLE_VERTEX, `#version 300 es
      precision highp float;
      uniform sampler2D depths;
      uniform ivec2 at;
      out vec4 code;
      void main() {
        float whole = min(floor(texelFetch(depths, at, 0).r * 16777216.0), 16777215.0);
        code = vec4(floor(whole / 65536.0), floor(mod(whole, 65536.0) / 256.0), mod(whole, 256.0), 255.0) / 255.0;
      }`);
    const probe = this.probe ??= this.framebuffer(this.texture(gl.RGBA8, [1, 1]), null);
    stage.use();
    bind(gl, stage, { depths: this.targets.whole.depths });
    gl.uniform2i(stage.uniform("at"), Math.min(Math.max(Math.floor(x), 0), this.size[0] - 1), Math.min(Math.max(Math.floor(y), 0), this.size[1] - 1));
    this.over(probe, [1, 1]);
    const read = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, read);
    const stored = (read[0] * 65536 + read[1] * 256 + read[2]) / 16777216;
    const code = stored < 0.5 ? 4 * stored - 1 : 2 * stored - 1;
    return code > 0 ? code / ((1 - code) * this.unit) : 0;
  }

  /** Makes the targets of a picture of a size. */
  resize(width, height) {
    const gl = this.gl;
    for (const object of this.made ?? []) {
      if (object instanceof WebGLTexture) gl.deleteTexture(object);
      else gl.deleteFramebuffer(object);
    }
    this.made = [];
    this.size = [width, height];
    [gl.canvas.width, gl.canvas.height] = this.size;
    const picture = () => {
      const [depths, sums] = [this.texture(gl.DEPTH_COMPONENT32F, this.size), this.texture(gl.RGBA16F, this.size)];
      return { depths, sums, surface: this.framebuffer(sums, depths), blended: this.framebuffer(sums, null) };
    };
    const level = (size) => {
      const color = this.texture(gl.RGBA16F, size);
      return { color, framebuffer: this.framebuffer(color, null), size };
    };
    const [whole, lasting] = [picture(), picture()];
    const [pulled, pushed] = [[], []];
    let size = this.size;
    do {
      size = size.map((side) => Math.ceil(side / 2));
      pulled.push(level(size));
    } while (pulled.length < MOST_LEVELS && Math.max(...size) > 1);
    for (const { size: same } of pulled.slice(0, -1)) pushed.push(level(same));
    const shown = this.texture(gl.RGBA8, this.size);
    this.targets = { whole, lasting, pulled, pushed, picture: shown, shown: this.framebuffer(shown, whole.depths), lastingKey: null };
  }

  texture(format, [width, height]) {
    const gl = this.gl;
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    for (const which of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, which, gl.NEAREST);
    for (const which of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, which, gl.CLAMP_TO_EDGE);
    this.made?.push(made);
    return made;
  }

  /** What is drawn into: a texture of colors, one of depths, or both. */
  framebuffer(color, depths) {
    const gl = this.gl;
    const made = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, made);
    if (color) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, color, 0);
    if (depths) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depths, 0);
    gl.drawBuffers([color ? gl.COLOR_ATTACHMENT0 : gl.NONE]);
    this.made?.push(made);
    return made;
  }
}

/** A program that the driver makes meanwhile; what is wrong with it shows when it is first used. */
class Stage {
  constructor(gl, vertexText, fragmentText) {
    this.gl = gl;
    this.places = new Map();
    this.linked = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.linked, shader);
    }
    gl.linkProgram(this.linked);
  }

  use() {
    const { gl, linked } = this;
    if (!this.isChecked && !gl.getProgramParameter(linked, gl.LINK_STATUS) && !gl.isContextLost()) {
      const shaders = gl.getAttachedShaders(linked).map((shader) => gl.getShaderInfoLog(shader));
      throw new CannotDraw(`The graphics driver refuses a shader: ${[gl.getProgramInfoLog(linked), ...shaders].join(" ")}`);
    }
    this.isChecked = true;
    gl.useProgram(linked);
  }

  /** The place of a uniform. */
  uniform(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.linked, name));
    return this.places.get(name);
  }
}

/** Binds textures to the samplers of a program in use. */
function bind(gl, stage, textures) {
  Object.entries(textures).forEach(([name, bound], unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, bound);
    gl.uniform1i(stage.uniform(name), unit);
  });
}
