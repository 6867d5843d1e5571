// Draws samples into a canvas by WebGL2. All samples lie in one buffer, image after image; a frame is drawn from those whose span it is in.

import { axis, place, subtract, turnedBack } from "./math.js";
import { SAMPLE_BYTES } from "./decode.js";
import {
  BLEND_FRAGMENT, BLEND_VERTEX, FINISH, PULL_LEVEL, PULL_PICTURE, PUSH_LEVEL, SURFACE_FRAGMENT, SURFACE_VERTEX, WHOLE_VERTEX,
} from "./shaders.js";

/** Footprints whose centers lie this far outside the picture are drawn too, pixels. */
const GUARD = 64;

/** Levels that holes are filled from, at most: holes of that many doublings of a pixel. */
const MOST_LEVELS = 9;

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
      surface: program(gl, SURFACE_VERTEX, SURFACE_FRAGMENT),
      blend: program(gl, BLEND_VERTEX, BLEND_FRAGMENT),
      pullPicture: program(gl, WHOLE_VERTEX, PULL_PICTURE),
      pullLevel: program(gl, WHOLE_VERTEX, PULL_LEVEL),
      pushLevel: program(gl, WHOLE_VERTEX, PUSH_LEVEL),
      finish: program(gl, WHOLE_VERTEX, FINISH),
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

  /** Takes the samples of some images, which begin at sample `first` of all. */
  upload(samples, images, first) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, first * SAMPLE_BYTES, samples);
    for (const image of images) {
      this.ranges.push({ ...image, first });
      first += image.samples;
    }
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

  /** Draws a frame, by its index, from a pose through a lens, whose size is that of the picture. */
  draw(frame, pose, lens) {
    const gl = this.gl;
    const [width, height] = lens;
    if (this.size[0] !== width || this.size[1] !== height) this.resize(width, height);
    const { targets, programs } = this;
    const alive = this.ranges.filter((range) => range.start <= frame && frame < range.end);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.surface);
    gl.viewport(-GUARD, -GUARD, width + 2 * GUARD, height + 2 * GUARD);
    gl.depthMask(true);
    gl.clearDepth(0);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.GREATER);
    gl.disable(gl.BLEND);
    gl.bindVertexArray(this.samples);
    this.drawSamples(programs.surface, alive, pose, lens);

    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.sums.framebuffer);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    const blend = programs.blend;
    gl.useProgram(blend.program);
    bind(gl, blend, { depths: targets.depths });
    gl.uniform4f(blend.uniform("lens"), lens[2], lens[3], lens[4], lens[5]);
    gl.uniform1f(blend.uniform("surface_ratio"), 1 / (1 + this.scene.depth_tolerance / Math.sqrt(lens[2] * lens[3])));
    this.drawSamples(blend, alive, pose, lens);
    gl.disable(gl.BLEND);
    gl.bindVertexArray(this.nothing);
    this.fillHoles();
    this.finish(pose, lens);
  }

  drawSamples(stage, alive, pose, lens) {
    const gl = this.gl;
    gl.useProgram(stage.program);
    gl.uniform1f(stage.uniform("guard"), GUARD);
    gl.uniform2f(stage.uniform("size"), lens[0], lens[1]);
    gl.uniform1f(stage.uniform("unit"), this.unit);
    for (let nth = 0; nth < alive.length;) {
      const { camera, level, first } = alive[nth];
      if (nth === 0 || alive[nth - 1].camera !== camera || alive[nth - 1].level !== level) {
        this.setCamera(stage, this.scene.cameras[camera], 1 << level, pose, lens);
      }
      let end = first;
      for (; nth < alive.length && alive[nth].camera === camera && alive[nth].level === level && alive[nth].first === end; nth++) {
        end += alive[nth].samples;
      }
      gl.drawArrays(gl.POINTS, first, end - first);
    }
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

  fillHoles() {
    const gl = this.gl;
    const { targets, programs } = this;
    const { pulled, pushed, sums, depths } = targets;
    pulled.forEach((level, nth) => {
      const stage = nth === 0 ? programs.pullPicture : programs.pullLevel;
      const before = nth === 0 ? { size: this.size } : pulled[nth - 1];
      gl.useProgram(stage.program);
      bind(gl, stage, nth === 0 ? { sums: sums.texture, depths } : { colors_of_level: before.color, nearness_of_level: before.nearness });
      gl.uniform2i(stage.uniform("last"), before.size[0] - 1, before.size[1] - 1);
      over(gl, level);
    });
    const stage = programs.pushLevel;
    gl.useProgram(stage.program);
    for (let nth = pushed.length - 1; nth >= 0; nth--) {
      const coarser = pushed[nth + 1] ?? pulled[nth + 1];
      bind(gl, stage, {
        colors_of_level: pulled[nth].color, nearness_of_level: pulled[nth].nearness,
        coarser_colors: coarser.color, coarser_nearness: coarser.nearness,
      });
      over(gl, pushed[nth]);
    }
  }

  finish(pose, lens) {
    const gl = this.gl;
    const { targets } = this;
    const stage = this.programs.finish;
    const filled = targets.pushed[0] ?? targets.pulled[0];
    const [a, b, c] = [axis(pose, 0), axis(pose, 1), axis(pose, 2)];
    gl.useProgram(stage.program);
    bind(gl, stage, {
      sums: targets.sums.texture, depths: targets.depths, coarser_colors: filled.color, coarser_nearness: filled.nearness, sky: this.sky,
    });
    gl.uniform1i(stage.uniform("has_sky"), this.sky ? 1 : 0);
    gl.uniform1f(stage.uniform("rows"), lens[1]);
    gl.uniform3fv(stage.uniform("sky_corner"), c.map((part, i) => part - a[i] * lens[4] / lens[2] - b[i] * lens[5] / lens[3]));
    gl.uniform3fv(stage.uniform("sky_across"), a.map((part) => part / lens[2]));
    gl.uniform3fv(stage.uniform("sky_down"), b.map((part) => part / lens[3]));
    over(gl, { framebuffer: null, size: this.size });
  }

  /** The inverse depth in the middle of a pixel of the last picture, counted from its upper left corner; 0 at infinity and in holes. */
  inverseDepthAt(x, y) {
    const gl = this.gl;
    if (!this.targets) return 0;
    // Depth cannot be read directly: it is copied into the bytes of a color of one pixel.
    const stage = this.programs.depthAt ??= program(gl, WHOLE_VERTEX, `#version 300 es
      precision highp float;
      uniform sampler2D depths;
      uniform ivec2 at;
      out vec4 code;
      void main() {
        float whole = min(floor(texelFetch(depths, at, 0).r * 16777216.0), 16777215.0);
        code = vec4(floor(whole / 65536.0), floor(mod(whole, 65536.0) / 256.0), mod(whole, 256.0), 255.0) / 255.0;
      }`);
    const probe = this.probe ??= colorTarget(gl, [gl.RGBA8], [1, 1]);
    gl.bindVertexArray(this.nothing);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.useProgram(stage.program);
    bind(gl, stage, { depths: this.targets.depths });
    gl.uniform2i(stage.uniform("at"), Math.min(Math.max(Math.floor(x), 0), this.size[0] - 1), Math.min(Math.max(Math.floor(y), 0), this.size[1] - 1));
    over(gl, probe);
    const read = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, read);
    const stored = (read[0] * 65536 + read[1] * 256 + read[2]) / 16777216;
    const code = stored < 0.5 ? 4 * stored - 1 : 2 * stored - 1;
    return code > 0 ? code / ((1 - code) * this.unit) : 0;
  }

  /** Makes the targets of a picture of a size. */
  resize(width, height) {
    const gl = this.gl;
    for (const object of this.targets?.all ?? []) {
      if (object instanceof WebGLTexture) gl.deleteTexture(object);
      else gl.deleteFramebuffer(object);
    }
    this.size = [width, height];
    [gl.canvas.width, gl.canvas.height] = this.size;
    const depths = texture(gl, gl.DEPTH_COMPONENT32F, this.size);
    const surface = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, surface);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depths, 0);
    gl.drawBuffers([gl.NONE]);
    const sums = colorTarget(gl, [gl.RGBA16F], this.size);
    const [pulled, pushed] = [[], []];
    let size = this.size;
    while (pulled.length < MOST_LEVELS && Math.max(...size) > 1) {
      size = size.map((side) => Math.ceil(side / 2));
      pulled.push(levelTarget(gl, size));
    }
    for (const level of pulled.slice(0, -1)) pushed.push(levelTarget(gl, level.size));
    const levels = [...pulled, ...pushed].flatMap((level) => [level.color, level.nearness, level.framebuffer]);
    this.targets = {
      depths, surface, sums: { ...sums, texture: sums.textures[0] }, pulled, pushed,
      all: [depths, surface, sums.framebuffer, ...sums.textures, ...levels],
    };
  }
}

/** A program, and the places of its uniforms by their names. */
function program(gl, vertexText, fragmentText) {
  const linked = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(linked, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
      throw new CannotDraw(`The graphics driver refuses a shader: ${gl.getShaderInfoLog(shader)}`);
    }
  }
  gl.linkProgram(linked);
  if (!gl.getProgramParameter(linked, gl.LINK_STATUS)) {
    throw new CannotDraw(`The graphics driver refuses a program: ${gl.getProgramInfoLog(linked)}`);
  }
  const places = new Map();
  const uniform = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(linked, name));
    return places.get(name);
  };
  return { program: linked, uniform };
}

function texture(gl, format, [width, height]) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
  for (const which of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, which, gl.NEAREST);
  for (const which of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, which, gl.CLAMP_TO_EDGE);
  return made;
}

/** What is drawn into: a texture of each format. */
function colorTarget(gl, formats, size) {
  const textures = formats.map((format) => texture(gl, format, size));
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  textures.forEach((made, nth) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + nth, gl.TEXTURE_2D, made, 0));
  gl.drawBuffers(textures.map((_, nth) => gl.COLOR_ATTACHMENT0 + nth));
  return { framebuffer, textures, size };
}

/** A level of filled holes. */
function levelTarget(gl, size) {
  const { framebuffer, textures: [color, nearness] } = colorTarget(gl, [gl.RGBA16F, gl.R16F], size);
  return { framebuffer, color, nearness, size };
}

/** Binds textures to the samplers of a program in use. */
function bind(gl, stage, textures) {
  Object.entries(textures).forEach(([name, bound], unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, bound);
    gl.uniform1i(stage.uniform(name), unit);
  });
}

/** Draws one triangle over the whole of a target. */
function over(gl, target) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
  gl.viewport(0, 0, target.size[0], target.size[1]);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}
