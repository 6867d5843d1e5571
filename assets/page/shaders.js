// The stages of a picture. Pictures are drawn with rows downward, as cameras count them; the last stage turns them over.
//
//   SURFACE   depth of the nearest sample of each pixel
//   BLEND     colors of all samples of that surface, weighted and summed
//   PULL      holes: averages at ever coarser levels, of the farthest surface around
//   PUSH      holes: colors of coarser levels carried into finer ones
//   FINISH    colors divided by their weights, holes filled, the sky behind; sRGB
//
// Source: for splats as oriented, projected reconstruction filters, Zwicker et al., Surface Splatting, SIGGRAPH 2001. The numbers are
// those of the kernel `surfel` of Overlook.

/** From a sample to its footprint in the picture: a plane has an inverse depth that is linear in the pixels of any pinhole camera. */
const FOOTPRINT = `
precision highp float;
layout(location = 0) in vec2 pixel;
layout(location = 1) in float inverse_depth;
layout(location = 2) in vec2 slope;
layout(location = 3) in vec4 color_flags;

uniform vec3 corner, across, down, origin;
uniform float focal_ratio, per_footprint, guard;
uniform vec2 size;

struct Footprint {
  vec3 ray;           // in the picture, before the division, without the way between the cameras
  vec2 center;        // in pixels of the picture
  vec3 plane;         // inverse depth at the center, and its growth by column and row
  mat2 jacobian;      // pixels of the picture by pixels of the camera
  float reciprocal;   // not positive behind the picture
  float deviation;    // of inverse depth within the footprint
};

const float EDGE_FOOTPRINTS = 8.0;
const float MAX_STRETCH = 1.5;
const float CORE_REACH = 0.525;

Footprint footprint() {
  Footprint f;
  f.ray = corner + across * (pixel.x + 0.5) + down * (pixel.y + 0.5);
  vec3 point = f.ray + origin * inverse_depth;
  float r = 1.0 / point.z;
  vec2 uv = point.xy * r;
  float w = inverse_depth * r;
  vec2 growth = slope * (EDGE_FOOTPRINTS * per_footprint * inverse_depth);
  vec3 right = across + origin * growth.x;
  vec3 below = down + origin * growth.y;
  // Columns: by the camera's column, by its row.
  mat2 j = mat2((right.xy - uv * right.z) * r, (below.xy - uv * below.z) * r);
  vec2 by_camera = (growth - w * vec2(right.z, below.z)) * r;
  float determinant = determinant(j);
  vec2 by_picture = abs(determinant) > 1e-6
    ? vec2(by_camera.x * j[1][1] - by_camera.y * j[0][1], by_camera.y * j[0][0] - by_camera.x * j[1][0]) / determinant
    : vec2(0.0);
  f.center = uv;
  f.plane = vec3(w, by_picture);
  f.jacobian = j;
  f.reciprocal = r;
  f.deviation = CORE_REACH * (abs(by_camera.x) + abs(by_camera.y));
  return f;
}

/** Where a footprint is drawn: a square about its center; a margin keeps those at the edge of the picture from being clipped. */
void place(Footprint f, float half_side) {
  bool is_seen = f.reciprocal > 0.0;
  vec2 inside = (f.center + guard) / (size + 2.0 * guard);
  gl_Position = is_seen ? vec4(inside * 2.0 - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 2.0 * half_side + 0.5;
}
`;

/** Depths in the buffer: nearer is greater, behind all others what is doubtful; 0: nothing. */
const DEPTH_CODE = `
uniform float unit;

float code_of(float inverse_depth, bool is_doubtful) {
  float x = inverse_depth * unit;
  float code = x / (1.0 + x);
  return is_doubtful ? 0.25 + 0.25 * code : 0.5 + 0.5 * code;
}

float inverse_depth_of(float code) {
  float x = code < 0.5 ? 4.0 * code - 1.0 : 2.0 * code - 1.0;
  return x / ((1.0 - x) * unit);
}
`;

export const SURFACE_VERTEX = `#version 300 es
${FOOTPRINT}
flat out vec2 center;
flat out vec4 inverse;
flat out vec4 plane;
flat out float doubtful;

void main() {
  Footprint f = footprint();
  mat2 j = f.jacobian;
  float d = determinant(j);
  float i = abs(d) > 1e-6 ? 1.0 / d : 0.0;
  center = f.center;
  inverse = vec4(j[1][1], -j[1][0], -j[0][1], j[0][0]) * i;
  plane = vec4(f.plane, f.deviation);
  doubtful = mod(floor(color_flags.a * 255.0 + 0.5), 2.0);
  vec2 reach = CORE_REACH * (abs(j[0]) + abs(j[1]));
  place(f, max(0.5, min(max(reach.x, reach.y), MAX_STRETCH * focal_ratio * f.reciprocal)));
}
`;

export const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
flat in vec2 center;
flat in vec4 inverse;
flat in vec4 plane;
flat in float doubtful;
${DEPTH_CODE}
void main() {
  vec2 offset = gl_FragCoord.xy - center;
  vec2 camera = abs(vec2(dot(inverse.xy, offset), dot(inverse.zw, offset)));
  vec2 pixels = abs(offset);
  if (max(camera.x, camera.y) > 0.525 && max(pixels.x, pixels.y) > 0.5) discard;
  float deviation = clamp(dot(plane.yz, offset), -plane.w, plane.w);
  gl_FragDepth = code_of(max(plane.x + deviation, 0.0), doubtful > 0.5);
}
`;

export const BLEND_VERTEX = `#version 300 es
${FOOTPRINT}
uniform vec4 lens;
flat out vec2 center;
flat out vec3 plane;
flat out vec3 conic;
flat out vec4 weighted;

const float SOURCE_VARIANCE = 0.15;
const float SCREEN_VARIANCE = 0.1;
const float KERNEL_END = 6.0;
const float MAX_REACH = 64.0;
const float BESIDE_EDGE = 0.5;

vec3 direction(vec3 image) {
  return vec3((image.xy - lens.zw * image.z) / lens.xy, image.z);
}

void main() {
  Footprint f = footprint();
  mat2 j = f.jacobian;
  float xx = SOURCE_VARIANCE * (j[0].x * j[0].x + j[1].x * j[1].x) + SCREEN_VARIANCE;
  float yy = SOURCE_VARIANCE * (j[0].y * j[0].y + j[1].y * j[1].y) + SCREEN_VARIANCE;
  float xy = SOURCE_VARIANCE * (j[0].x * j[0].y + j[1].x * j[1].y);
  float area = max(abs(determinant(j)), 0.05);
  center = f.center;
  plane = f.plane;
  conic = vec3(yy, -2.0 * xy, xx) / ((xx * yy - xy * xy) * KERNEL_END);
  float limit = min(1.5 + 2.0 * MAX_STRETCH * focal_ratio * f.reciprocal, MAX_REACH);
  float cosine = dot(normalize(direction(f.ray)), normalize(direction(vec3(f.center, 1.0))));
  float trust = max(cosine, 0.01) * (color_flags.a * 255.0 > 1.5 ? BESIDE_EDGE : 1.0);
  vec3 encoded = color_flags.rgb;
  vec3 linear = mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
  weighted = vec4(linear, 1.0) * (trust / area);
  place(f, min(sqrt(KERNEL_END * max(xx, yy)), limit));
}
`;

export const BLEND_FRAGMENT = `#version 300 es
precision highp float;
flat in vec2 center;
flat in vec3 plane;
flat in vec3 conic;
flat in vec4 weighted;
uniform sampler2D depths;
uniform float surface_ratio;
${DEPTH_CODE}
out vec4 sum;
void main() {
  vec2 offset = gl_FragCoord.xy - center;
  float share = 1.0 - dot(conic, vec3(offset.x * offset.x, offset.x * offset.y, offset.y * offset.y));
  if (share <= 0.0) discard;
  float nearest = inverse_depth_of(texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r);
  float depth = plane.x + dot(plane.yz, offset);
  // Neither what is behind the surface, nor a nearer sample whose kernel only touches the edge of the pixel.
  if (depth < nearest * surface_ratio || depth * surface_ratio > nearest) discard;
  sum = weighted * (share * share);
}
`;

/** One triangle over the whole picture. */
export const WHOLE_VERTEX = `#version 300 es
void main() {
  vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
  gl_Position = vec4(at, 0.0, 1.0);
}
`;

/** Reads a pixel of the picture: its color, and in `w` 1, or 0 where it is a hole; \`farness\` is its inverse depth in the buffer's code. */
const READ_PICTURE = `
uniform sampler2D sums;
uniform sampler2D depths;
const float LEAST_WEIGHT = 1.0 / 65536.0;

vec4 read_picture(ivec2 at, out float nearness) {
  vec4 sum = texelFetch(sums, at, 0);
  float code = texelFetch(depths, at, 0).r;
  nearness = code < 0.5 ? 4.0 * code - 1.0 : 2.0 * code - 1.0;
  return sum.w > LEAST_WEIGHT ? vec4(sum.rgb / sum.w, 1.0) : vec4(0.0);
}
`;

const pull = (read) => `#version 300 es
precision highp float;
layout(location = 0) out vec4 pulled;
layout(location = 1) out vec4 pulled_nearness;
${read}
uniform ivec2 last;

void main() {
  ivec2 first = 2 * ivec2(gl_FragCoord.xy);
  vec4 colors[4];
  float nearness[4];
  float farthest = 2.0;
  for (int nth = 0; nth < 4; nth++) {
    ivec2 at = first + ivec2(nth & 1, nth >> 1);
    colors[nth] = read_picture(min(at, last), nearness[nth]);
    if (colors[nth].w > 0.0) farthest = min(farthest, nearness[nth]);
  }
  vec4 sum = vec4(0.0);
  float near = 0.0;
  for (int nth = 0; nth < 4; nth++) {
    if (colors[nth].w > 0.0 && nearness[nth] <= farthest * 1.1 + 1e-4) {
      sum += colors[nth];
      near += nearness[nth];
    }
  }
  pulled = sum.w > 0.0 ? vec4(sum.rgb / sum.w, 1.0) : vec4(0.0);
  pulled_nearness = vec4(sum.w > 0.0 ? near / sum.w : 0.0);
}
`;

/** From the picture to the first coarser level, and from a level to the next. */
export const PULL_PICTURE = pull(READ_PICTURE);
export const PULL_LEVEL = pull(`
uniform sampler2D colors_of_level;
uniform sampler2D nearness_of_level;
vec4 read_picture(ivec2 at, out float nearness) {
  nearness = texelFetch(nearness_of_level, at, 0).r;
  return texelFetch(colors_of_level, at, 0);
}
`);

/** A level between its pixels, without those that are empty. */
const READ_COARSER = `
uniform sampler2D coarser_colors;
uniform sampler2D coarser_nearness;

vec4 read_coarser(vec2 at, out float nearness) {
  ivec2 last = textureSize(coarser_colors, 0) - 1;
  vec2 place = at * 0.5 - 0.5;
  ivec2 first = ivec2(floor(place));
  vec2 share = place - vec2(first);
  vec4 sum = vec4(0.0);
  nearness = 0.0;
  for (int nth = 0; nth < 4; nth++) {
    ivec2 step = ivec2(nth & 1, nth >> 1);
    ivec2 from = clamp(first + step, ivec2(0), last);
    vec2 part = mix(1.0 - share, share, vec2(step));
    vec4 color = texelFetch(coarser_colors, from, 0) * part.x * part.y;
    sum += color;
    nearness += texelFetch(coarser_nearness, from, 0).r * color.w;
  }
  nearness = sum.w > 0.0 ? nearness / sum.w : 0.0;
  return sum.w > 0.0 ? vec4(sum.rgb / sum.w, 1.0) : vec4(0.0);
}
`;

export const PUSH_LEVEL = `#version 300 es
precision highp float;
layout(location = 0) out vec4 pushed;
layout(location = 1) out vec4 pushed_nearness;
uniform sampler2D colors_of_level;
uniform sampler2D nearness_of_level;
${READ_COARSER}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  pushed = texelFetch(colors_of_level, at, 0);
  float nearness = texelFetch(nearness_of_level, at, 0).r;
  if (pushed.w == 0.0) pushed = read_coarser(gl_FragCoord.xy, nearness);
  pushed_nearness = vec4(nearness);
}
`;

export const FINISH = `#version 300 es
precision highp float;
out vec4 shown;
uniform float rows;
uniform vec3 sky_corner, sky_across, sky_down;
uniform bool has_sky;
uniform sampler2D sky;
${READ_PICTURE}
${READ_COARSER}
const float PI = 3.14159265358979;

vec3 decoded(vec3 encoded) {
  return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}

vec3 sky_color(vec3 direction) {
  vec2 place = vec2(atan(direction.y, direction.x) / (2.0 * PI) + 0.5, acos(clamp(direction.z, -1.0, 1.0)) / PI);
  return decoded(textureLod(sky, place, 0.0).rgb);
}

void main() {
  vec2 at = vec2(gl_FragCoord.x, rows - gl_FragCoord.y);
  float nearness;
  vec4 color = read_picture(ivec2(at), nearness);
  if (color.w == 0.0) {
    color = read_coarser(at, nearness);
    if (has_sky && (color.w == 0.0 || nearness < 1e-4)) {
      color.rgb = sky_color(normalize(sky_corner + sky_across * at.x + sky_down * at.y));
    }
  }
  vec3 linear = clamp(color.rgb, 0.0, 1.0);
  shown = vec4(mix(1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308))), 1.0);
}
`;
