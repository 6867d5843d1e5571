// The stages of a picture. Pictures are drawn with rows downward, as cameras count them, and turned over at last.
//
//   SURFACE   depth of the nearest sample of each pixel
//   BLEND     colors of all samples of that surface, weighted and summed
//   CARRY     the same sums of lasting samples, drawn before, where they are still nearest
//   PULL      averages at ever coarser levels, of the farthest surface around
//   PUSH      colors of coarser levels carried into the gaps of finer ones
//   SHOW      colors divided by their weights, as sRGB
//   FILL      holes: what is around, or the sky
//   TURN_OVER onto the screen
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
uniform float focal_ratio, per_footprint, pixel_scale, guard;
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

/** How far a footprint reaches from its sample, in pixels of its camera: where they are magnified, over the gaps that pruning left. */
float core_reach(mat2 jacobian) {
  return 0.525 + 0.225 * smoothstep(1.2, 4.0, abs(determinant(jacobian)));
}

Footprint footprint() {
  Footprint f;
  f.ray = corner + across * (pixel.x * pixel_scale + 0.5) + down * (pixel.y * pixel_scale + 0.5);
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
  f.deviation = core_reach(j) * (abs(by_camera.x) + abs(by_camera.y));
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

/** Linear colors from sRGB. */
const DECODE = `
vec3 decoded(vec3 encoded) {
  return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}
`;

export const SURFACE_VERTEX = `#version 300 es
${FOOTPRINT}
flat out vec2 center;
flat out vec4 inverse;
flat out vec4 plane;
flat out vec2 doubtful_reach;
flat out vec3 color;
${DECODE}
void main() {
  Footprint f = footprint();
  mat2 j = f.jacobian;
  float d = determinant(j);
  float i = abs(d) > 1e-6 ? 1.0 / d : 0.0;
  center = f.center;
  inverse = vec4(j[1][1], -j[1][0], -j[0][1], j[0][0]) * i;
  plane = vec4(f.plane, f.deviation);
  color = decoded(color_flags.rgb);
  doubtful_reach = vec2(mod(floor(color_flags.a * 255.0 + 0.5), 2.0), core_reach(j));
  vec2 reach = doubtful_reach.y * (abs(j[0]) + abs(j[1]));
  place(f, max(0.5, min(max(reach.x, reach.y), MAX_STRETCH * focal_ratio * f.reciprocal)));
}
`;

/** The depth and, with the least weight, the color of the nearest sample: it is all that is seen where no kernel reaches the surface. */
export const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
flat in vec2 center;
flat in vec4 inverse;
flat in vec4 plane;
flat in vec2 doubtful_reach;
flat in vec3 color;
out vec4 sum;
const float LEAST_WEIGHT = 0.001;
${DEPTH_CODE}
void main() {
  vec2 offset = gl_FragCoord.xy - center;
  vec2 camera = abs(vec2(dot(inverse.xy, offset), dot(inverse.zw, offset)));
  vec2 pixels = abs(offset);
  if (max(camera.x, camera.y) > doubtful_reach.y && max(pixels.x, pixels.y) > 0.5) discard;
  float deviation = clamp(dot(plane.yz, offset), -plane.w, plane.w);
  gl_FragDepth = code_of(max(plane.x + deviation, 0.0), doubtful_reach.x > 0.5);
  sum = vec4(color, 1.0) * LEAST_WEIGHT;
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
const float WEIGHT = 8.0;

${DECODE}
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
  weighted = vec4(decoded(color_flags.rgb), 1.0) * (WEIGHT * trust / area);
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
  // Weights that are too small for half floats would turn colors white.
  sum = weighted * max(share * share, 0.004);
}
`;

/** One triangle over the whole picture, at a depth in the buffer. */
export const WHOLE_VERTEX = `#version 300 es
uniform float depth;
void main() {
  vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
  gl_Position = vec4(at, depth * 2.0 - 1.0, 1.0);
}
`;

/** Of a picture whose lasting samples are drawn already: the sums of their colors where they are not behind what is nearer now. */
export const CARRY = `#version 300 es
precision highp float;
uniform sampler2D lasting_sums;
uniform sampler2D lasting_depths;
uniform sampler2D depths;
uniform float surface_ratio;
${DEPTH_CODE}
out vec4 sum;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float lasting = texelFetch(lasting_depths, at, 0).r;
  float nearest = texelFetch(depths, at, 0).r;
  bool is_shown = lasting == nearest || lasting > 0.0 && inverse_depth_of(lasting) >= inverse_depth_of(nearest) * surface_ratio;
  if (!is_shown) discard;
  sum = texelFetch(lasting_sums, at, 0);
}
`;

/** What is known of a surface in a level of filled holes: its color, and in `w` how near it is, or 0 where nothing is. */
const SKY_CODE = `
// What is not nearer is at infinity.
const float SKY = 1.1 / 1024.0;
`;

const READ_PICTURE = `
uniform sampler2D sums;
uniform sampler2D depths;

vec4 read_finer(ivec2 at) {
  vec4 sum = texelFetch(sums, at, 0);
  float code = texelFetch(depths, at, 0).r;
  return sum.w > 0.0 ? vec4(sum.rgb / sum.w, (code < 0.5 ? 4.0 * code - 1.0 : 2.0 * code - 1.0) + 1.0 / 1024.0) : vec4(0.0);
}
`;

const READ_LEVEL = `
uniform sampler2D level;

vec4 read_finer(ivec2 at) {
  return texelFetch(level, at, 0);
}
`;

const pull = (read) => `#version 300 es
precision highp float;
out vec4 pulled;
uniform ivec2 last;
${read}
${SKY_CODE}
/** One where there is a surface as far as the farthest; where there is none, one for the sky. */
float part_of(float near, float limit) {
  bool is_of_kind = limit > SKY ? near > SKY : near > 0.0;
  return is_of_kind && near <= limit ? 1.0 : 0.0;
}

void main() {
  ivec2 first = 2 * ivec2(gl_FragCoord.xy);
  ivec2 next = min(first + 1, last);
  vec4 a = read_finer(first);
  vec4 b = read_finer(ivec2(next.x, first.y));
  vec4 c = read_finer(ivec2(first.x, next.y));
  vec4 d = read_finer(next);
  vec4 near = vec4(a.w, b.w, c.w, d.w);
  vec4 surfaces = mix(near, vec4(2.0), lessThanEqual(near, vec4(SKY)));
  float farthest = min(min(surfaces.x, surfaces.y), min(surfaces.z, surfaces.w));
  float limit = farthest < 2.0 ? farthest * 1.1 : SKY;
  vec4 sum = a * part_of(a.w, limit) + b * part_of(b.w, limit) + c * part_of(c.w, limit) + d * part_of(d.w, limit);
  float count = part_of(a.w, limit) + part_of(b.w, limit) + part_of(c.w, limit) + part_of(d.w, limit);
  pulled = count > 0.0 ? sum / count : vec4(0.0);
}
`;

/** From the picture to the first coarser level, and from a level to the next: the farthest surface around. */
export const PULL_PICTURE = pull(READ_PICTURE);
export const PULL_LEVEL = pull(READ_LEVEL);

/** A level between its pixels, without those that are empty. */
const READ_COARSER = `
uniform sampler2D coarser;

vec4 read_coarser(vec2 at) {
  ivec2 last = textureSize(coarser, 0) - 1;
  vec2 place = at * 0.5 - 0.5;
  ivec2 first = ivec2(floor(place));
  vec2 share = place - vec2(first);
  vec4 sum = vec4(0.0);
  float count = 0.0;
  for (int nth = 0; nth < 4; nth++) {
    ivec2 step = ivec2(nth & 1, nth >> 1);
    vec2 parts = mix(1.0 - share, share, vec2(step));
    vec4 color = texelFetch(coarser, clamp(first + step, ivec2(0), last), 0);
    float part = color.w > 0.0 ? parts.x * parts.y : 0.0;
    sum += color * part;
    count += part;
  }
  return count > 0.0 ? sum / count : vec4(0.0);
}
`;

export const PUSH_LEVEL = `#version 300 es
precision highp float;
out vec4 pushed;
uniform sampler2D level;
${READ_COARSER}
void main() {
  pushed = texelFetch(level, ivec2(gl_FragCoord.xy), 0);
  if (pushed.w == 0.0) pushed = read_coarser(gl_FragCoord.xy);
}
`;

const ENCODE = `
vec3 encoded(vec3 linear) {
  linear = clamp(linear, 0.0, 1.0);
  return mix(1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}
`;

export const SHOW = `#version 300 es
precision highp float;
uniform sampler2D sums;
out vec4 shown;
${ENCODE}
void main() {
  vec4 sum = texelFetch(sums, ivec2(gl_FragCoord.xy), 0);
  shown = vec4(encoded(sum.rgb / max(sum.w, 1e-9)), 1.0);
}
`;

/** Drawn where there is a hole, or the sky: the surfaces around where they enclose it, else the sky, if there is one. */
export const FILL = `#version 300 es
precision highp float;
out vec4 shown;
uniform vec3 sky_corner, sky_across, sky_down;
uniform bool has_sky, is_open, is_sky;
uniform sampler2D sky;
uniform sampler2D level;
${READ_COARSER}
${ENCODE}
const float PI = 3.14159265358979;
const int STEPS = 12;
const int FAR[12] = int[12](1, 2, 3, 4, 6, 8, 11, 15, 21, 29, 40, 56);
// A hole is enclosed by surfaces that it sees in all of eight directions; a speck of the sky by near ones, in nearly all.
const float ENCLOSED = 8.0;
const float ENCLOSED_SKY = 7.0;
const int CLOSE = 4;
${SKY_CODE}
${DECODE}
vec3 sky_color(vec3 direction) {
  vec2 place = vec2(atan(direction.y, direction.x) / (2.0 * PI) + 0.5, acos(clamp(direction.z, -1.0, 1.0)) / PI);
  return decoded(textureLod(sky, place, 0.0).rgb);
}

/** In how many of eight directions a surface is the first that is seen, in a picture half as large: near by, and anywhere; and the sky. */
vec3 seen_around() {
  ivec2 last = textureSize(level, 0) - 1;
  vec3 count = vec3(0.0);
  for (int direction = 0; direction < 9; direction++) {
    ivec2 step = ivec2(direction % 3, direction / 3) - 1;
    if (step == ivec2(0)) continue;
    for (int nth = 0; nth < STEPS; nth++) {
      ivec2 at = ivec2(gl_FragCoord.xy) / 2 + step * FAR[nth];
      if (any(lessThan(at, ivec2(0))) || any(greaterThan(at, last))) break;
      float near = texelFetch(level, at, 0).w;
      if (near == 0.0) continue;
      count += near > SKY ? vec3(nth < CLOSE ? 1.0 : 0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
      break;
    }
  }
  return count;
}

void main() {
  vec4 around = read_coarser(gl_FragCoord.xy);
  vec3 color = around.rgb;
  vec3 seen = seen_around();
  // A speck of the sky amid surfaces is a gap between samples.
  if (is_sky && (seen.x < ENCLOSED_SKY || around.w <= SKY)) discard;
  bool is_enclosed = is_sky || seen.y >= ENCLOSED || !is_open && seen.z <= seen.y;
  if (has_sky && (around.w <= SKY || !is_enclosed)) {
    color = sky_color(normalize(sky_corner + sky_across * gl_FragCoord.x + sky_down * gl_FragCoord.y));
  }
  shown = vec4(encoded(color), 1.0);
}
`;

/** Onto the screen, whose rows go upward. */
export const TURN_OVER = `#version 300 es
precision highp float;
out vec4 shown;
uniform sampler2D picture;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  shown = texelFetch(picture, ivec2(at.x, textureSize(picture, 0).y - 1 - at.y), 0);
}
`;
