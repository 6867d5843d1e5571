// The stages that fill holes, as Overlook's renderer does and with its numbers.
//
//   PULL  means of ever larger squares of pixels, of the farthest surface in each
//   FILL  for each pixel of a hole, the surface that it sees across the hole, and its color by the means
//   ROWS  sums of what fills holes, along rows
//   SHOW  the picture on the screen: what fills holes, averaged, and what is shown over it
//
// Sources: Gortler et al., The Lumigraph, SIGGRAPH 1996; Solh and AlRegib, Hierarchical Hole-Filling for Depth-Based View Synthesis, 2012.

import { DECODE } from "./shaders.js";
import { PIXEL_CODE, PRECISE } from "./gather.js";
import { ROUND } from "./round.js";

/** Levels that holes are filled from, at most: holes of that many doublings of a pixel. */
export const MOST_LEVELS = 10;

/** What pixels are: `marked` is the picture, with a negative inverse depth in holes, which tells of what kind they are. */
const PICTURE = `
uniform usampler2D marked;
uniform bool has_sky;
uniform float footprints, focal;
${PIXEL_CODE}
const float HOLE = -1.0;
const float OPEN_HOLE = -1e38;
const float SKY_HOLE = -3e38;

/** The factor by which inverse depths of one surface differ at most over a distance. */
float tolerance(float pixels) {
  return 1.0 + (footprints + pixels) / focal;
}

/** Holes are filled from what this holds for; where there is a sky it fills by itself. */
bool is_source(Pixel pixel) {
  return pixel.kind % 2u == SHOWN_KIND && (pixel.w > 0.0 || !has_sky);
}
`;

/** Cells have their color, in place of the share of a pixel their weight, and their inverse depth. */
const CELLS = `
uniform usampler2D odd_levels, even_levels;
uniform ivec4 levels[${MOST_LEVELS}];

/** A cell of a level, the first of which is 1. */
Pixel cell_at(int level, ivec2 at) {
  ivec4 place = levels[level - 1];
  ivec2 there = place.xy + clamp(at, ivec2(0), place.zw - 1);
  return unpack(level % 2 == 1 ? texelFetch(odd_levels, there, 0) : texelFetch(even_levels, there, 0));
}
`;

export const PULL = `${PRECISE}
out uvec4 pulled;
uniform int level;
uniform ivec2 first;
${PICTURE}
${CELLS}
Pixel finer(ivec2 at) {
  if (level > 1) return cell_at(level - 1, at);
  ivec2 last = textureSize(marked, 0) - 1;
  Pixel pixel = unpack(texelFetch(marked, min(at, last), 0));
  pixel.share = is_source(pixel) ? 1.0 : 0.0;
  return pixel;
}

void main() {
  ivec2 at = 2 * (ivec2(gl_FragCoord.xy) - first);
  float farthest = 1e30;
  Pixel parts[4];
  for (int nth = 0; nth < 4; nth++) {
    parts[nth] = finer(at + ivec2(nth & 1, nth >> 1));
    if (parts[nth].share > 0.0) farthest = min(farthest, parts[nth].w);
  }
  vec4 sum = vec4(0.0);
  float w = 0.0;
  for (int nth = 0; nth < 4; nth++) {
    if (parts[nth].share <= 0.0 || parts[nth].w > farthest * tolerance(float(1 << level))) continue;
    sum += parts[nth].share * vec4(parts[nth].color, 1.0);
    w += parts[nth].share * parts[nth].w;
  }
  pulled = sum.a > 0.0 ? pack(Pixel(sum.rgb / sum.a, sum.a / 4.0, w / sum.a, 0u)) : uvec4(0u);
}
`;

const SKY = `
uniform sampler2D sky;
uniform vec3 sky_corner, sky_across, sky_down;
const float PI = 3.14159265358979;
${DECODE}
vec3 sky_at(vec2 place) {
  vec3 direction = normalize(sky_corner + sky_across * place.x + sky_down * place.y);
  vec2 on_map = vec2(atan(direction.y, direction.x) / (2.0 * PI) + 0.5, acos(clamp(direction.z, -1.0, 1.0)) / PI);
  return decoded(textureLod(sky, on_map, 0.0).rgb);
}
`;

/** What fills a pixel: its color, in place of its share that of the sky, its inverse depth, and one of three kinds. */
const FILLING = `
const uint NOT_FILLED = 0u;
const uint FILLED = 1u;
const uint ONLY_SKY = 2u;
`;

/** Where cameras tell what they saw, round things go on. */
export const FILL = (camerasTell) => `${PRECISE}
out uvec4 filling;
uniform int level_count;
${PICTURE}
${CELLS}
${FILLING}
const float NONE = 1e9;
const float MAX_WIDTH_RATIO = 4.0;
const float LIMIT_SLACK = 0.95;
const float FULL_SHARE = 0.5;
const float MAX_BLOCK_RATIO = 8.0;
const float MAX_OPEN_SHARE = 1.0 / 64.0;
const float FACING_DENSITY = 16.0;
const float ENCLOSED_DENSITY = 24.0;
const float ENCLOSED_SKY = 0.9;
const int MOST_FACING = 1;
const ivec2 DIRECTIONS[8] = ivec2[8](
  ivec2(-1, 0), ivec2(-1, -1), ivec2(0, -1), ivec2(1, -1), ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1)
);

float distances[8];
float depths[8];
vec3 colors[8];
int counts[8];
${camerasTell ? ROUND : ""}

/** Looks in eight directions for what a hole is filled from; whether it is open to the sky. */
bool look_around(ivec2 from, bool takes_all) {
  ivec2 last = textureSize(marked, 0) - 1;
  int facing = 0;
  bool sees_sky = false;
  bool sees_nothing = true;
  int surfaces = 0;
  for (int direction = 0; direction < 8; direction++) {
    ivec2 step = DIRECTIONS[direction];
    distances[direction] = NONE;
    depths[direction] = 0.0;
    bool is_open = true;
    for (int count = 1; count < 4096; count++) {
      ivec2 at = from + step * count;
      if (any(lessThan(at, ivec2(0))) || any(greaterThan(at, last))) break;
      uvec4 code = texelFetch(marked, at, 0);
      float w = uintBitsToFloat(code.z);
      if (is_open && w != OPEN_HOLE) {
        is_open = false;
        sees_nothing = false;
        if (w > 0.0) surfaces |= 1 << direction;
        sees_sky = sees_sky || w == 0.0 || w == SKY_HOLE;
      }
      if (w < 0.0 && !(takes_all && w == SKY_HOLE) || w == 0.0 && has_sky && !takes_all) continue;
      counts[direction] = count;
      distances[direction] = float(count) * (step.x != 0 && step.y != 0 ? 1.41421356 : 1.0);
      depths[direction] = max(w, 0.0);
      colors[direction] = unpack(code).color;
      break;
    }
  }
  for (int nth = 0; nth < 4; nth++) facing += surfaces >> nth & surfaces >> nth + 4 & 1;
  return sees_nothing || sees_sky && facing <= MOST_FACING;
}

/** Inverse depth and distance of the surface that goes on through the hole: the farthest across it where it is narrow. */
vec2 surface_behind(float limit) {
  float widths[4];
  float narrowest = NONE;
  for (int nth = 0; nth < 4; nth++) {
    float both = distances[nth] + distances[nth + 4];
    widths[nth] = both < NONE ? both : 2.0 * min(distances[nth], distances[nth + 4]);
    if (both < NONE) narrowest = min(narrowest, both);
  }
  vec2 found = vec2(0.0, NONE);
  vec2 nearest = vec2(-1.0, NONE);
  for (int direction = 0; direction < 8; direction++) {
    float distance = distances[direction];
    float w = depths[direction];
    if (distance >= NONE) continue;
    if (w > nearest.x || w == nearest.x && distance < nearest.y) nearest = vec2(w, distance);
    bool counts = w >= limit * LIMIT_SLACK && widths[direction % 4] <= MAX_WIDTH_RATIO * narrowest;
    if (counts && (found.y >= NONE || w < found.x || w == found.x && distance < found.y)) found = vec2(w, distance);
  }
  return found.y < NONE ? found : nearest;
}

/** The color and inverse depth of a surface by the means of its cells, and how much of the pixel they cover. */
float push(ivec2 at, vec2 range, float reach, out vec4 color) {
  color = vec4(0.0);
  float weight = 0.0;
  for (int level = 1; level <= level_count; level++) {
    float block = float(1 << level);
    if (block > MAX_BLOCK_RATIO * reach || weight > 1.0 - MAX_OPEN_SHARE) break;
    float factor = tolerance(block);
    float open = 1.0 - weight;
    vec2 place = (vec2(at) + 0.5) / block - 0.5;
    ivec2 first = ivec2(floor(place));
    vec2 between = place - vec2(first);
    for (int corner = 0; corner < 4; corner++) {
      ivec2 step = ivec2(corner & 1, corner >> 1);
      Pixel cell = cell_at(level, first + step);
      if (cell.share <= 0.0 || cell.w < range.x / factor || cell.w > range.y * factor) continue;
      vec2 shares = mix(1.0 - between, between, vec2(step));
      float part = open * shares.x * shares.y * min(cell.share / FULL_SHARE, 1.0);
      color += part * vec4(cell.color, cell.w);
      weight += part;
    }
  }
  if (weight > 0.0) color /= weight;
  return weight;
}

float sky_share(float hole, float hidden, bool is_open) {
  if (hole >= HOLE) return 0.0;
  if (hole != OPEN_HOLE) return ENCLOSED_SKY * exp(-ENCLOSED_DENSITY * hidden);
  return is_open ? 1.0 : exp(-FACING_DENSITY * hidden);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  Pixel pixel = unpack(texelFetch(marked, at, 0));
  filling = uvec4(0u, 0u, 0u, NOT_FILLED);
  if (pixel.w >= 0.0) return;
  Pixel result = Pixel(vec3(0.0), 1.0, 0.0, ONLY_SKY);
  bool is_open = pixel.w != SKY_HOLE && look_around(at, pixel.w == HOLE);
  float limit = pixel.w > OPEN_HOLE && pixel.w < HOLE ? HOLE - pixel.w : 0.0;
  vec2 chosen = pixel.w == SKY_HOLE ? vec2(0.0, NONE) : surface_behind(limit);
  ${camerasTell ? "ivec4 votes = pixel.w == SKY_HOLE ? ivec4(0, 0, 0, -1) : votes_at(at);" : ""}
  ${camerasTell ? "if (votes.w >= 0) chosen = vec2(depths[votes.w], distances[votes.w]);" : ""}
  if (chosen.y < NONE && (chosen.x > 0.0 || !has_sky)) {
    vec2 range = vec2(chosen.x);
    float reach = 0.0;
    vec4 mean = vec4(0.0);
    float weight = 0.0;
    for (int direction = 0; direction < 8; direction++) {
      float w = depths[direction];
      float distance = distances[direction];
      if (distance >= NONE || max(w, chosen.x) > min(w, chosen.x) * tolerance(distance + chosen.y)) continue;
      range = vec2(min(range.x, w), max(range.y, w));
      reach = max(reach, distance);
      mean += vec4(colors[direction], w) / (distance * distance);
      weight += 1.0 / (distance * distance);
    }
    vec4 color;
    if (push(at, range, reach, color) <= 0.0) color = mean / weight;
    float hidden = unpackHalf2x16(pixel.kind).y;
    float share = has_sky ? sky_share(pixel.w, hidden, is_open) : 0.0;
    ${camerasTell ? "share = sky_share_by(votes, share);" : ""}
    result = Pixel(color.rgb, share, color.a, FILLED);
  }
  filling = pack(result);
}
`;

const SUMS = `
uniform usampler2D fillings;
${FILLING}
/** Means reach this share of the picture's width to each side. */
const float REACH = 1.0 / 128.0;

int reach_px() {
  return max(int(float(textureSize(fillings, 0).x) * REACH), 1);
}
`;

export const ROWS = `${PRECISE}
out uvec4 sums;
${PIXEL_CODE}
${SUMS}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  sums = uvec4(0u);
  if (texelFetch(fillings, at, 0).w == NOT_FILLED) return;
  vec4 colors = vec4(0.0);
  vec2 shares = vec2(0.0);
  int last = min(at.x + reach_px(), textureSize(fillings, 0).x - 1);
  for (int x = max(at.x - reach_px(), 0); x <= last; x++) {
    Pixel filling = unpack(texelFetch(fillings, ivec2(x, at.y), 0));
    if (filling.kind == NOT_FILLED) continue;
    shares += vec2(filling.share, 1.0);
    if (filling.kind == FILLED) colors += vec4(filling.color, 1.0);
  }
  sums = uvec4(packHalf2x16(colors.rg), packHalf2x16(colors.ba), packHalf2x16(shares), 1u);
}
`;

const ENCODE = `
vec3 encoded(vec3 linear) {
  linear = clamp(linear, 0.0, 1.0);
  return mix(1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}
`;

/** Onto the screen, whose rows go upward. */
export const SHOW = `${PRECISE}
out vec4 shown;
uniform usampler2D sums;
${PICTURE}
${SUMS}
${SKY}
${ENCODE}
const float WHOLE = 0.999;

bool is_beside_shown(ivec2 at) {
  ivec2 last = textureSize(marked, 0) - 1;
  for (int nth = 0; nth < 9; nth++) {
    ivec2 there = clamp(at + ivec2(nth % 3, nth / 3) - 1, ivec2(0), last);
    if (texelFetch(marked, there, 0).w % 2u == SHOWN_KIND) return true;
  }
  return false;
}

/** What fills a pixel, without its neighbors. */
vec3 filling_alone(ivec2 at, Pixel filling) {
  if (has_sky && filling.share > 0.0) return mix(filling.color, sky_at(vec2(at) + 0.5), filling.share);
  return filling.color;
}

vec3 filling_at(ivec2 at, Pixel filling) {
  if (filling.kind == ONLY_SKY) return has_sky ? sky_at(vec2(at) + 0.5) : vec3(0.0);
  vec4 colors = vec4(0.0);
  vec2 shares = vec2(0.0);
  int last = min(at.y + reach_px(), textureSize(fillings, 0).y - 1);
  for (int y = max(at.y - reach_px(), 0); y <= last; y++) {
    uvec4 code = texelFetch(sums, ivec2(at.x, y), 0);
    colors += vec4(unpackHalf2x16(code.x), unpackHalf2x16(code.y));
    shares += unpackHalf2x16(code.z);
  }
  // Beside what is shown the choice is sure.
  if (!is_beside_shown(at)) filling.color = colors.rgb / max(colors.a, 1.0);
  filling.share = shares.x / max(shares.y, 1.0);
  return filling_alone(at, filling);
}

void main() {
  ivec2 size = textureSize(marked, 0);
  ivec2 at = ivec2(int(gl_FragCoord.x), size.y - 1 - int(gl_FragCoord.y));
  Pixel pixel = unpack(texelFetch(marked, at, 0));
  vec3 color = pixel.color;
  if (pixel.w < 0.0) {
    color = mix(filling_at(at, unpack(texelFetch(fillings, at, 0))), color, pixel.share);
  } else if (pixel.share < WHOLE) {
    vec4 below = vec4(0.0);
    for (int nth = 0; nth < 9; nth++) {
      ivec2 there = clamp(at + ivec2(nth % 3, nth / 3) - 1, ivec2(0), size - 1);
      Pixel filling = unpack(texelFetch(fillings, there, 0));
      if (filling.kind != NOT_FILLED) below += vec4(filling_alone(there, filling), 1.0);
    }
    if (below.a > 0.0) color = mix(below.rgb / below.a, color, pixel.share);
  }
  shown = vec4(encoded(color), 1.0);
}
`;
