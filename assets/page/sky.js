// The stages that tell, where there is a sky, what a hole shows: cameras tell up to where they saw its line of sight free. They are those of
// Overlook's renderer, with its numbers.
//
//   CELL     the samples of all cameras carried into one, in cells of 2×2 pixels
//   FREE     how far lines of sight of a camera are free at the corners of its cells
//   SQUARES  the nearest and the farthest surface in each square of pixels
//   AROUND   the same, with the squares around
//   LINES    where the hidden part of a pixel's line of sight ends, and its share
//   MARK     the picture with its holes, and their kinds
//
// Sources: Curless and Levoy, A Volumetric Method for Building Complex Models from Range Images, SIGGRAPH 1996; Kutulakos and Seitz, A
// Theory of Shape by Space Carving, IJCV 2000.

import { DEPTH_CODE } from "./shaders.js";
import { PIXEL_CODE, PRECISE } from "./gather.js";

/** Cameras that are asked at most, the nearest ones, and the empty cells around those of each. */
export const [MOST_ASKED, CELL_BORDER] = [12, 2];
/** Numbers of a row of `asked`, four to a texel. */
export const ASKED_TEXELS = 4;
/** Columns and rows of a square. */
export const SQUARE = 16;

export const CELL_VERTEX = `${PRECISE}
layout(location = 0) in vec2 pixel;
layout(location = 1) in float inverse_depth;
uniform vec3 corner, across, down, origin;
uniform vec2 size;
uniform float pixel_scale;
${DEPTH_CODE}
void main() {
  vec3 point = corner + across * (pixel.x * pixel_scale + 0.5) + down * (pixel.y * pixel_scale + 0.5) + origin * inverse_depth;
  float r = 1.0 / point.z;
  vec2 cell = floor(point.xy * r);
  bool is_inside = r > 0.0 && all(greaterThanEqual(cell, vec2(0.0))) && all(lessThan(cell, size - ${2 * CELL_BORDER}.0));
  vec2 at = (cell + ${CELL_BORDER}.5) / size * 2.0 - 1.0;
  gl_Position = is_inside ? vec4(at, code_of(inverse_depth * r, 0) * 2.0 - 1.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
}
`;

export const CELL_FRAGMENT = `${PRECISE}
void main() {}
`;

export const FREE = `${PRECISE}
out uvec4 farthest;
uniform sampler2DArray cells;
uniform int layer;
${DEPTH_CODE}
void main() {
  float least = 3e38;
  for (int nth = 0; nth < 4; nth++) {
    float code = texelFetch(cells, ivec3(ivec2(gl_FragCoord.xy) + ivec2(nth & 1, nth >> 1), layer), 0).r;
    if (code > 0.0) least = min(least, inverse_depth_of(code));
  }
  farthest = uvec4(floatBitsToUint(least));
}
`;

export const SQUARES = `${PRECISE}
out uvec4 ranges;
uniform usampler2D picture;
${PIXEL_CODE}
void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * ${SQUARE};
  ivec2 last = min(first + ${SQUARE}, textureSize(picture, 0));
  vec2 range = vec2(0.0, 3e38);
  for (int y = first.y; y < last.y; y++) {
    for (int x = first.x; x < last.x; x++) {
      float w = uintBitsToFloat(texelFetch(picture, ivec2(x, y), 0).z);
      if (w > 0.0) range = vec2(max(range.x, w), min(range.y, w));
    }
  }
  ranges = uvec4(floatBitsToUint(range), 0u, 0u);
}
`;

export const AROUND = `${PRECISE}
out uvec4 ranges;
uniform usampler2D squares;
void main() {
  vec2 range = vec2(0.0, 3e38);
  for (int nth = 0; nth < 25; nth++) {
    ivec2 at = clamp(ivec2(gl_FragCoord.xy) + ivec2(nth % 5, nth / 5) - 2, ivec2(0), textureSize(squares, 0) - 1);
    vec2 there = uintBitsToFloat(texelFetch(squares, at, 0).rg);
    range = vec2(max(range.x, there.x), min(range.y, there.y));
  }
  ranges = uvec4(floatBitsToUint(range), 0u, 0u);
}
`;

/** What surrounds the pixels of the picture. */
const SURROUNDINGS = `
uniform usampler2D picture, around;
${PIXEL_CODE}
const float NEARER = 2.0;
const float BEYOND_FARTHEST = 0.9;
const float OUTSIDE = 3e38;
const ivec2 DIRECTIONS[8] = ivec2[8](
  ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(-1, 1), ivec2(-1, 0), ivec2(0, -1), ivec2(-1, -1), ivec2(1, -1)
);

/** Nearer surfaces are looked for this far, pixels. */
int reach() {
  return clamp(textureSize(picture, 0).x / 32, 8, 16);
}

float shown_at(ivec2 at) {
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, textureSize(picture, 0)))) return OUTSIDE;
  return max(uintBitsToFloat(texelFetch(picture, at, 0).z), 0.0);
}

vec2 range_at(ivec2 at) {
  return uintBitsToFloat(texelFetch(around, at / ${SQUARE}, 0).rg);
}
`;

export const RAY_TEST = `
uniform sampler2D asked;
uniform int asked_count;
uniform usampler2DArray free;
uniform int depth_count;

/** Whether a camera saw a point's surroundings free (1), or something before them (2); 0 where it saw nothing. */
int look(int camera, vec2 at, float w) {
  vec4 first = texelFetch(asked, ivec2(0, camera), 0);
  vec4 across = texelFetch(asked, ivec2(1, camera), 0);
  vec4 down = texelFetch(asked, ivec2(2, camera), 0);
  vec4 origin = texelFetch(asked, ivec2(3, camera), 0);
  vec3 point = first.xyz + across.xyz * at.x + down.xyz * at.y + origin.xyz * w;
  if (point.z <= 0.0) return 0;
  float r = 1.0 / point.z;
  vec2 corner = clamp(point.xy * r + 1.5, vec2(0.0), vec2(across.w, down.w));
  float farthest = uintBitsToFloat(texelFetch(free, ivec3(ivec2(corner), camera), 0).r);
  return farthest < w * r * first.w ? 1 : farthest < 2e38 ? 2 : 0;
}

/** Where the longest hidden stretch of a line of sight ends, and the hidden share; the first is −1 where all is free, −2 where it is not known. */
vec2 test_line(vec2 at, float near, float far) {
  float step = (near - far) / float(depth_count);
  int hidden = 0;
  int run = 0;
  int longest = 0;
  int end = 0;
  bool is_free = true;
  for (int nth = 0; nth < depth_count; nth++) {
    float w = near - step * (float(nth) + 0.5);
    int found = 0;
    for (int camera = 0; camera < asked_count && (found & 1) == 0; camera++) found |= look(camera, at, w);
    bool is_hidden = found == 2;
    is_free = is_free && (found & 1) == 1;
    run = is_hidden ? run + 1 : 0;
    hidden += is_hidden ? 1 : 0;
    if (run > longest) {
      longest = run;
      end = nth + 1;
    }
  }
  if (hidden > 0) return vec2(near - step * float(end), float(hidden) / float(depth_count));
  return vec2(is_free ? -1.0 : -2.0, 0.0);
}
`;

export const LINES = `${PRECISE}
out uvec4 line;
${SURROUNDINGS}
${RAY_TEST}
const float BEFORE_SHOWN = 1.04;
const int ENOUGH_TO_TEST = 5;

bool may_be_enclosed(ivec2 at, float w) {
  int missing = 0;
  for (int nth = 0; nth < 8 && missing <= 8 - ENOUGH_TO_TEST; nth++) {
    bool is_found = false;
    for (int step = 1; step <= reach() && !is_found; step++) is_found = shown_at(at + DIRECTIONS[nth] * step) > w * NEARER;
    missing += is_found ? 0 : 1;
  }
  return missing <= 8 - ENOUGH_TO_TEST;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float shown = shown_at(at);
  vec2 range = range_at(at);
  float far = max(shown * BEFORE_SHOWN, range.y * BEYOND_FARTHEST);
  line = uvec4(floatBitsToUint(vec2(-1.0, 0.0)), 0u, 0u);
  if (range.x <= far) return;
  ivec2 inside = textureSize(picture, 0) - reach();
  bool is_inside = all(greaterThanEqual(at, ivec2(reach()))) && all(lessThan(at, inside));
  if (is_inside && range.x <= shown * NEARER || !may_be_enclosed(at, shown)) return;
  vec2 found = test_line(vec2(at), range.x, far);
  if (found.x >= 0.0) line = uvec4(floatBitsToUint(found), 0u, 0u);
}
`;

export const MARK = `${PRECISE}
out uvec4 marked;
uniform usampler2D lines;
${SURROUNDINGS}
${RAY_TEST}
const int ENOUGH = 7;
const int COARSE = 4;
const float HOLE = -1.0;
const float OPEN_HOLE = -1e38;
const float SKY_HOLE = -3e38;

bool is_enclosed(ivec2 at, float w) {
  int missing = 0;
  for (int nth = 0; nth < 8; nth++) {
    bool is_found = false;
    for (int step = 1; step <= reach(); step++) {
      ivec2 there = at + DIRECTIONS[nth] * step;
      is_found = shown_at(there) > w * NEARER;
      if (is_found || uintBitsToFloat(texelFetch(lines, there, 0).x) < 0.0) break;
    }
    missing += is_found ? 0 : 1;
    if (missing > 8 - ENOUGH) return false;
  }
  return true;
}

/** A hole that nothing encloses: its mark, and the share of its line of sight that is hidden. What it shows is invented anyway: squares are tested as one. */
vec2 open_hole(ivec2 at) {
  ivec2 first = at / COARSE * COARSE;
  vec2 range = range_at(first);
  if (range.x == 0.0) return vec2(SKY_HOLE, 0.0);
  vec2 found = test_line(vec2(first + COARSE / 2), range.x, range.y * BEYOND_FARTHEST);
  return found.x >= 0.0 ? vec2(OPEN_HOLE, found.y) : vec2(found.x == -1.0 ? SKY_HOLE : HOLE, 0.0);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  uvec4 code = texelFetch(picture, at, 0);
  Pixel pixel = unpack(code);
  marked = code;
  vec2 line = uintBitsToFloat(texelFetch(lines, at, 0).rg);
  vec2 mark = vec2(1.0, 0.0);
  if (line.x >= 0.0 && is_enclosed(at, max(pixel.w, 0.0))) {
    mark = vec2(HOLE - line.x, pixel.w > 0.0 ? 1.0 : line.y);
    if (pixel.kind == SHOWN_KIND) pixel.share = 0.0;
  } else if (pixel.kind == HOLE_KIND) {
    mark = open_hole(at);
  }
  if (mark.x > 0.0) return;
  // What surfaces enclose, and was seen behind them, shows no sky.
  pixel.w = mark.x;
  pixel.kind = packHalf2x16(vec2(0.0, mark.y >= 1.0 ? 60000.0 : mark.y));
  marked = pack(pixel);
}
`;
