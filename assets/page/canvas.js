// WebGL2 as the renderer uses it: programs, and textures that are drawn into. Numbers are kept as bits in whole numbers, which every device
// can draw.

/** A reason, in words for people, for which nothing can be drawn. */
export class CannotDraw extends Error {}

export class Canvas {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, powerPreference: "high-performance" });
    if (!gl) throw new CannotDraw("This browser has no WebGL2, which draws the scene. Another browser, or a newer one, will show it.");
    this.gl = gl;
    this.nothing = gl.createVertexArray();
    this.compiling = gl.getExtension("KHR_parallel_shader_compile");
  }

  /** A program of two texts. */
  stage(vertexText, fragmentText) {
    return new Stage(this.gl, vertexText, fragmentText, this.compiling);
  }

  /** Draws one triangle over a part of a target: its first column and row, columns and rows; over all of it where none is given. */
  over({ framebuffer, size }, [x, y, width, height] = [0, 0, ...size]) {
    const { gl } = this;
    gl.bindVertexArray(this.nothing);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, ...size);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(x, y, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }

  /** The size of what is on the screen; a new one empties it. */
  resize([width, height]) {
    const { canvas } = this.gl;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  }

  /** A texture of a format, with layers where it is to have some; it is added to what is `made`. */
  texture(format, [width, height], made, layers = 0) {
    const { gl } = this;
    const kind = layers > 0 ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
    const texture = gl.createTexture();
    gl.bindTexture(kind, texture);
    if (layers > 0) gl.texStorage3D(kind, 1, format, width, height, layers);
    else gl.texStorage2D(kind, 1, format, width, height);
    for (const which of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(kind, which, gl.NEAREST);
    for (const which of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(kind, which, gl.CLAMP_TO_EDGE);
    texture.isArray = layers > 0;
    made.push(texture);
    return texture;
  }

  /** What is drawn into: a texture of colors, one of depths, or both, or a layer of either. */
  framebuffer(color, depths, made, layer = 0) {
    const { gl } = this;
    const framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    for (const [texture, point] of [[color, gl.COLOR_ATTACHMENT0], [depths, gl.DEPTH_ATTACHMENT]]) {
      if (texture?.isArray) gl.framebufferTextureLayer(gl.FRAMEBUFFER, point, texture, 0, layer);
      else if (texture) gl.framebufferTexture2D(gl.FRAMEBUFFER, point, gl.TEXTURE_2D, texture, 0);
    }
    gl.drawBuffers([color ? gl.COLOR_ATTACHMENT0 : gl.NONE]);
    made.push(framebuffer);
    return framebuffer;
  }

  /** A texture that is drawn into. */
  target(format, size, made) {
    const texture = this.texture(format, size, made);
    return { texture, size, framebuffer: this.framebuffer(texture, null, made) };
  }

  /** Depths, and beside them what the nearest sample of each pixel is. */
  nearestTarget(size, made) {
    const { gl } = this;
    const [depths, own] = [this.texture(gl.DEPTH_COMPONENT32F, size, made), this.texture(gl.RGBA8, size, made)];
    return { depths, own, size, framebuffer: this.framebuffer(own, depths, made) };
  }

  /** A table of numbers, four to a texel; `before` is drawn over, if it is as large. */
  table(numbers, columns, before) {
    const { gl } = this;
    const rows = numbers.length / 4 / columns;
    const table = before?.rows === rows ? before : Object.assign(this.texture(gl.RGBA32F, [columns, rows], []), { rows });
    gl.bindTexture(gl.TEXTURE_2D, table);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, columns, rows, gl.RGBA, gl.FLOAT, numbers);
    return table;
  }

  /** The number that the bits of a part of a pixel are. */
  floatAt({ framebuffer }, [x, y], part) {
    const { gl } = this;
    const bits = new Uint32Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.readPixels(x, y, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
    return new Float32Array(bits.buffer)[part];
  }

  /** Asks the device to tell when it has drawn all until now. */
  watch() {
    this.gl.deleteSync(this.fence ?? null);
    this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
  }

  /** Whether it has. */
  isIdle() {
    return !this.fence || this.gl.clientWaitSync(this.fence, 0, 0) !== this.gl.TIMEOUT_EXPIRED;
  }

  /** Gives back the memory of what was made. */
  forget(made) {
    const { gl } = this;
    for (const object of made) {
      if (object instanceof WebGLTexture) gl.deleteTexture(object);
      else gl.deleteFramebuffer(object);
    }
  }
}

/** A program that the driver makes meanwhile; what is wrong with it shows when it is first used. */
class Stage {
  constructor(gl, vertexText, fragmentText, compiling) {
    this.gl = gl;
    this.compiling = compiling;
    this.linked = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.linked, shader);
    }
    gl.linkProgram(this.linked);
  }

  /** Whether the driver has made the program; what is known of it is then asked for. */
  isMade() {
    const { gl, linked, compiling } = this;
    if (!this.uniforms && (!compiling || gl.isContextLost() || gl.getProgramParameter(linked, compiling.COMPLETION_STATUS_KHR))) this.uniforms = this.checked();
    return Boolean(this.uniforms);
  }

  /** Takes the program into use, with textures for its samplers and numbers for its other uniforms. */
  use(textures = {}, numbers = {}) {
    const { gl, linked } = this;
    this.uniforms ??= this.checked();
    gl.useProgram(linked);
    Object.entries(textures).forEach(([name, bound], unit) => {
      const uniform = this.uniforms.get(name);
      if (!uniform) return;
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(bound?.isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D, bound);
      gl.uniform1i(uniform.place, unit);
    });
    this.numbers(numbers);
  }

  /** Sets uniforms of the program in use; what it has not is left out. */
  numbers(numbers) {
    for (const [name, value] of Object.entries(numbers)) {
      const uniform = this.uniforms.get(name);
      if (uniform) this.gl[uniform.setter](uniform.place, [value].flat(2));
    }
  }

  /** The places of the uniforms, and how each is set. */
  checked() {
    const { gl, linked } = this;
    const uniforms = new Map();
    if (gl.isContextLost()) return uniforms;
    if (!gl.getProgramParameter(linked, gl.LINK_STATUS)) {
      const shaders = gl.getAttachedShaders(linked).map((shader) => gl.getShaderInfoLog(shader));
      throw new CannotDraw(`The graphics driver refuses a shader: ${[gl.getProgramInfoLog(linked), ...shaders].join(" ")}`);
    }
    const setters = new Map([
      [gl.FLOAT, "uniform1fv"], [gl.FLOAT_VEC2, "uniform2fv"], [gl.FLOAT_VEC3, "uniform3fv"], [gl.FLOAT_VEC4, "uniform4fv"],
      [gl.INT_VEC2, "uniform2iv"], [gl.INT_VEC4, "uniform4iv"],
    ]);
    for (let nth = 0; nth < gl.getProgramParameter(linked, gl.ACTIVE_UNIFORMS); nth++) {
      const { name, type } = gl.getActiveUniform(linked, nth);
      uniforms.set(name.replace("[0]", ""), { place: gl.getUniformLocation(linked, name), setter: setters.get(type) ?? "uniform1iv" });
    }
    return uniforms;
  }
}
