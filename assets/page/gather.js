// The stages that find what a pixel shows: surface first, color second. They are those of Overlook's kernel `gather`, with its numbers.
//
//   SILHOUETTE  at steps in depth, how much of a pixel the nearer surface covers, by the votes of the cameras
//   GATHER      each surface looked up in the cameras that saw it best
//
// A view is a camera at one level of its samples. `views` has a row for each: from the depth buffer into the view, back, and both centers.
// `seen` has a layer for each camera: one pixel a sample, its inverse depth and its color, and 0 where there is none.
//
// Sources: Buehler et al., Unstructured Lumigraph Rendering, SIGGRAPH 2001; Merrell et al., Real-Time Visibility-Based Fusion of Depth
// Maps, ICCV 2007.

import { DECODE, DEPTH_CODE } from "./shaders.js";

/** Numbers of a row of `views`, four to a texel. */
export const VIEW_TEXELS = 10;

/** What the depth buffer and the picture are made of. */
export const PRECISE = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
precision highp usampler2D;
precision highp usampler2DArray;
`;

/** Pictures have one or two pixels of the depth buffer along each side of their own. */
const VIEWS = (subpixels) => `
const int subpixels = ${subpixels};
uniform sampler2D views;
uniform usampler2DArray seen;
uniform int view_count;
uniform vec3 first_ray, ray_across, ray_down;
uniform float surface_ratio;

const float USEFUL_RATE = 1.5;
const float MOST_SLANTED = 0.02;

vec4 of_view(int view, int nth) {
  return texelFetch(views, ivec2(nth, view), 0);
}

struct Reprojected {
  bool inside;
  ivec2 corner;
  vec2 between;
  float expected;
  float ratio;
};

Reprojected reproject(int view, vec2 at, float w) {
  vec4 origin = of_view(view, 3);
  vec3 point = of_view(view, 0).xyz + of_view(view, 1).xyz * at.x + of_view(view, 2).xyz * at.y + origin.xyz * w;
  float ratio = 1.0 / point.z;
  vec2 pixel = point.xy * ratio - 0.5;
  vec2 size = vec2(origin.w, of_view(view, 4).w);
  bool inside = point.z > 0.0 && all(greaterThan(pixel, vec2(-1.0))) && all(lessThan(pixel, size));
  vec2 corner = floor(pixel);
  return Reprojected(inside, ivec2(corner), pixel - corner, w * ratio, ratio);
}

vec4 bilinear(vec2 between) {
  vec2 back = 1.0 - between;
  return vec4(back.x * back.y, between.x * back.y, back.x * between.y, between.x * between.y);
}

float rate_of(int view, float ratio) {
  return of_view(view, 2).w * ratio * float(subpixels);
}

/** The cosine between the lines of sight of the picture and of a view, and their squared lengths. */
vec3 sights_of(int view, vec2 at, float w) {
  vec3 line = first_ray + ray_across * at.x + ray_down * at.y;
  vec3 sight = line + of_view(view, 8).xyz * w;
  vec2 squared = vec2(dot(line, line), dot(sight, sight));
  return vec3(dot(line, sight) / sqrt(squared.x * squared.y), squared);
}

float weight_of(int view, float ratio, vec2 at, float w) {
  float rate = min(rate_of(view, ratio), USEFUL_RATE);
  return rate * rate * max(sights_of(view, at, w).x, 0.01);
}

float weight_on_surface(int view, float ratio, vec2 at, float w, vec2 slope) {
  vec3 sights = sights_of(view, at, w);
  vec3 growth = vec3(slope, w - slope.x * at.x - slope.y * at.y);
  float facing = (1.0 + dot(of_view(view, 9).xyz, growth)) * sqrt(sights.y / sights.z);
  float rate = min(rate_of(view, ratio) * sqrt(clamp(facing, MOST_SLANTED, 1.0 / MOST_SLANTED)), USEFUL_RATE);
  return rate * rate * rate * max(sights.x, 0.01);
}

/** The 2×2 samples around a point; depths are negative where there is none. */
void find_quad(int view, ivec2 corner, out vec4 depth, out uvec4 colors) {
  ivec2 size = ivec2(of_view(view, 3).w, of_view(view, 4).w);
  ivec3 first = ivec3(of_view(view, 5).w, of_view(view, 6).w, of_view(view, 0).w);
  for (int nth = 0; nth < 4; nth++) {
    ivec2 at = corner + ivec2(nth & 1, nth >> 1);
    bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
    uvec2 found = inside ? texelFetch(seen, first + ivec3(at, 0), 0).rg : uvec2(0u);
    depth[nth] = found.x == 0u ? -1.0 : uintBitsToFloat(found.x - 1u);
    colors[nth] = found.y;
  }
}

/** Where a point of a view is in the depth buffer, before the division. */
vec3 seen_from(int view, vec2 pixel, float w) {
  return of_view(view, 4).xyz + of_view(view, 5).xyz * pixel.x + of_view(view, 6).xyz * pixel.y + of_view(view, 7).xyz * w;
}

bvec4 agreeing(vec4 depth, float expected, float limit) {
  bvec4 is_near = lessThanEqual(abs(depth - expected), vec4(limit));
  return bvec4(ivec4(is_near) * ivec4(greaterThanEqual(depth, vec4(0.0))));
}
`;

const DEPTHS = `
uniform sampler2D depths;
${DEPTH_CODE}
/** The inverse depth at a pixel of the depth buffer; negative in holes. Beyond its edge the outermost pixels repeat. */
float depth_or_fringe_at(ivec2 at) {
  float code = texelFetch(depths, clamp(at, ivec2(0), textureSize(depths, 0) - 1), 0).r;
  return code > 0.0 ? inverse_depth_of(code) : -1.0;
}

/** The same, negative in fringes too. */
float depth_at(ivec2 at) {
  float code = texelFetch(depths, clamp(at, ivec2(0), textureSize(depths, 0) - 1), 0).r;
  return code >= LEAST_CORE ? inverse_depth_of(code) : -1.0;
}
`;

/** A pixel of the depth buffer: bits of the inverse depths of the nearer and the farther surface, of the nearer one's share, and which of the 5×5 pixels around show them. */
export const SILHOUETTE = (subpixels) => `${PRECISE}
out uvec4 surfaces;
${VIEWS(subpixels)}
${DEPTHS}
const vec2 OWN_SHARE = vec2(0.15, 1.2);
const vec2 SUBPIXEL_SHARE = vec2(0.1, 1.6);
const vec2 SUBPIXEL_CRACK_SHARE = vec2(-1.3, 4.1);
const vec2 LESS_BY_MANY = vec2(0.25, 0.4);
const float MANY = 4.0;
const float LEAST_SHARE = 1.0 / 256.0;
const float UNKNOWN_WEIGHT = 0.5;
const float MAX_SLOPE = 8.0;
const float MIN_VOTES = 0.02;
const int SELF = 12;
const ivec2 AROUND[8] = ivec2[8](
  ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1), ivec2(-1, -1), ivec2(1, -1), ivec2(-1, 1), ivec2(1, 1)
);
const ivec2 ACROSS[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));

float near_by[25];

int place_of(ivec2 step) {
  return (step.y + 2) * 5 + step.x + 2;
}

float w_at(ivec2 step) {
  return near_by[place_of(step)];
}

/** The share of the pixel that the cameras give to the surface at inverse depth w; negative where too few saw it. */
float share_of(vec2 at, float w, bool is_crack) {
  float agree = 0.0;
  float total = 0.0;
  float largest = 0.0;
  for (int view = 0; view < view_count; view++) {
    Reprojected r = reproject(view, at, w);
    if (!r.inside) continue;
    vec4 depth;
    uvec4 colors;
    find_quad(view, r.corner, depth, colors);
    float weight = weight_of(view, r.ratio, at, w);
    vec4 shares = bilinear(r.between);
    vec4 agrees = vec4(agreeing(depth, r.expected, r.expected * of_view(view, 1).w));
    vec4 is_behind = (1.0 - agrees) * vec4(greaterThanEqual(depth, vec4(0.0))) * vec4(lessThan(depth, vec4(r.expected)));
    float same = dot(shares, agrees);
    float behind = dot(shares, is_behind);
    float unknown = max(1.0 - same - behind, 0.0);
    if (same > 0.0) {
      vec3 point = seen_from(view, vec2(r.corner) + r.between, dot(shares * agrees, depth) / same);
      vec2 off = abs(point.xy / point.z - at - 0.5);
      float displaced = same * min(max(off.x, off.y), 1.0);
      same -= displaced;
      behind += displaced;
    }
    unknown *= same > 0.0 ? UNKNOWN_WEIGHT : 0.0;
    agree += weight * (same + 0.5 * unknown);
    total += weight * (same + behind + unknown);
    largest = max(largest, weight);
  }
  if (total <= MIN_VOTES * largest) return -1.0;
  float many = clamp((total / largest - 1.0) / (MANY - 1.0), 0.0, 1.0);
  vec2 by = subpixels == 1 ? OWN_SHARE - vec2(LESS_BY_MANY.x * many, 0.0) :
    is_crack ? SUBPIXEL_CRACK_SHARE : SUBPIXEL_SHARE - vec2(LESS_BY_MANY.y * many, 0.0);
  float share = by.x + by.y * agree / total;
  return share < LEAST_SHARE ? 0.0 : share > 1.0 - LEAST_SHARE ? 1.0 : share;
}

void tell(float near, float far, float share, int near_at, int far_at) {
  surfaces = uvec4(floatBitsToUint(near), floatBitsToUint(far), floatBitsToUint(share), uint(near_at * 25 + far_at));
}

/** The nearest surface in front of a pixel that two opposite neighbors show. */
void find_crack(float own, out float crack, out int crack_at) {
  crack = -1.0;
  crack_at = SELF;
  int widths = subpixels == 2 ? 3 : 1;
  for (int nth = 0; nth < 4 * widths; nth++) {
    ivec2 ahead = ACROSS[nth & 3] * (nth / 4 == 2 ? 2 : 1);
    ivec2 back = -ACROSS[nth & 3] * (nth / 4 == 1 ? 2 : 1);
    float a = w_at(ahead);
    float b = w_at(back);
    float mean = 0.5 * (a + b);
    bool is_alike = min(a, b) >= 0.0 && min(a, b) >= max(a, b) * surface_ratio;
    if (is_alike && own < mean * surface_ratio && mean > crack) {
      crack = mean;
      crack_at = place_of(ahead);
    }
  }
}

/** The farthest surface behind a pixel that a neighbor shows, carried on to it; false if there is none, and no hole either. */
bool find_behind(float own, out float far, out int far_at) {
  float limit = own * surface_ratio;
  float farthest = limit;
  bool is_found = false;
  far = -1.0;
  far_at = SELF;
  for (int nth = 0; nth < 8; nth++) {
    float there = w_at(AROUND[nth]);
    if (there < 0.0) {
      is_found = true;
    } else if (there < limit) {
      float beyond = w_at(2 * AROUND[nth]);
      float growth = there - beyond;
      bool goes_on = beyond >= 0.0 && abs(growth) <= MAX_SLOPE * (1.0 - surface_ratio) * there;
      float w = goes_on ? max(there + growth, 0.0) : there;
      if (w < farthest) {
        farthest = w;
        is_found = true;
        far = w;
        far_at = place_of(AROUND[nth]);
      }
    }
  }
  return is_found;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float least = 1e30;
  float most = -1.0;
  for (int y = -1; y <= 1; y++) {
    for (int x = -1; x <= 1; x++) {
      float w = depth_at(pixel + ivec2(x, y));
      near_by[place_of(ivec2(x, y))] = w;
      least = min(least, w);
      most = max(most, w);
    }
  }
  float own = near_by[SELF];
  tell(own, -1.0, 1.0, SELF, SELF);
  float fringe = own < 0.0 ? depth_or_fringe_at(pixel) : -1.0;
  if (least >= most * surface_ratio && least >= 0.0 || most < 0.0 && fringe < 0.0) return;
  for (int nth = 0; nth < 25; nth++) {
    ivec2 step = ivec2(nth % 5, nth / 5) - 2;
    if (max(abs(step.x), abs(step.y)) == 2) near_by[nth] = depth_at(pixel + step);
  }
  float near;
  int near_at;
  find_crack(own, near, near_at);
  // A fringe is voted on like a crack.
  if (near < 0.0) near = fringe;
  bool is_crack = near >= 0.0;
  float far = own;
  int far_at = SELF;
  if (!is_crack) {
    if (own < 0.0 || !find_behind(own, far, far_at)) return;
    near = own;
  }
  float share = share_of(vec2(pixel), near, is_crack);
  if (share < 0.0) {
    if (!is_crack) return;
    share = 1.0;
  }
  // Without the votes' support there is no crack to close but a real gap.
  if (is_crack && share < 0.5 && own >= 0.0) return;
  // Of a whole pixel beside a hole no share is kept.
  if (far < 0.0 && subpixels == 1) share = share < 0.5 ? 0.0 : 1.0;
  tell(far < 0.0 && share <= 0.0 ? -1.0 : near, far, share, near_at, far_at);
}
`;

/** How a pixel of a picture is kept: halves of red and green, of blue and the share that is covered, bits of the inverse depth, and what is there: see KINDS. */
export const PIXEL_CODE = `
const uint HOLE_KIND = 0u;
const uint SHOWN_KIND = 1u;

struct Pixel {
  vec3 color;
  float share;
  float w;
  uint kind;
};

uvec4 pack(Pixel pixel) {
  return uvec4(packHalf2x16(pixel.color.rg), packHalf2x16(vec2(pixel.color.b, pixel.share)), floatBitsToUint(pixel.w), pixel.kind);
}

Pixel unpack(uvec4 pixel) {
  vec2 rest = unpackHalf2x16(pixel.y);
  return Pixel(vec3(unpackHalf2x16(pixel.x), rest.x), rest.y, uintBitsToFloat(pixel.z), pixel.w);
}
`;

export const GATHER = (subpixels) => `${PRECISE}
out uvec4 picture;
uniform usampler2D surfaces;
uniform sampler2D own;
${VIEWS(subpixels)}
${DEPTHS}
${DECODE}
${PIXEL_CODE}
const float FULL_COVERAGE = 0.99;
const float MIN_COVERAGE = 0.25;
const float OWN_SHARE = 0.2;
const float BESIDE_EDGE = 0.3;
const float EXACT = 0.005;
const float SUBPIXEL_WIDTH = 2.5;
const float MAX_SUBPIXELS = 4.0;
const float LEAST_SHOWN = 0.5;
const float MAX_GROWTH = 0.25;
const int MOST_PARTS = 4;
const int MOST_VIEWS = 4;

float sum_of_four(ivec2 at) {
  return depth_at(at) + depth_at(at + ivec2(1, 0)) + depth_at(at + ivec2(0, 1)) + depth_at(at + 1);
}

float growth(float before, float here, float after) {
  float back = here - before;
  float on = after - here;
  float least = abs(back) < abs(on) ? back : on;
  return back * on > 0.0 && abs(least) < MAX_GROWTH * here ? 0.125 * least : 0.0;
}

vec2 slope_around(ivec2 at) {
  float here = sum_of_four(at);
  return vec2(
    growth(sum_of_four(at - ivec2(2, 0)), here, sum_of_four(at + ivec2(2, 0))),
    growth(sum_of_four(at - ivec2(0, 2)), here, sum_of_four(at + ivec2(0, 2)))
  );
}

vec2 corrected(int view, Reprojected r, vec2 at, float depth) {
  vec3 there = seen_from(view, vec2(r.corner) + r.between, depth);
  vec3 line = of_view(view, 0).xyz + of_view(view, 1).xyz * at.x + of_view(view, 2).xyz * at.y;
  vec3 point = line * there.z + of_view(view, 3).xyz * depth;
  vec2 found = point.xy / point.z - 0.5 - vec2(r.corner);
  return there.z > 0.0 && point.z > 0.0 ? clamp(found, 0.0, 1.0) : r.between;
}

vec3 color_of(uint code) {
  vec3 root = vec3(code & 1023u, code >> 10u & 1023u, code >> 20u) / 1023.0;
  return root * root;
}

/** Color times the share of the pixel that samples cover, and that share. */
vec4 interpolated(int view, Reprojected r, vec2 at, inout bool is_beside) {
  vec4 depth;
  uvec4 colors;
  find_quad(view, r.corner, depth, colors);
  float limit = r.expected * of_view(view, 1).w;
  bvec4 agree = agreeing(depth, r.expected, limit);
  vec4 agrees = vec4(agree);
  vec4 shares = bilinear(r.between);
  float coverage = dot(shares, agrees);
  if (coverage < 1e-3) return vec4(0.0);
  float mean = dot(shares * agrees, depth) / coverage;
  if (abs(mean - r.expected) > EXACT * limit) shares = bilinear(corrected(view, r, at, mean));
  shares *= agrees;
  vec3 color = color_of(colors.x) * shares.x + color_of(colors.y) * shares.y + color_of(colors.z) * shares.z + color_of(colors.w) * shares.w;
  is_beside = is_beside || any(notEqual(agree, greaterThanEqual(depth, vec4(0.0))));
  return vec4(color, dot(shares, vec4(1.0)));
}

/** The same over as many places as samples of the view are in the pixel: one would alias fine detail. */
vec4 color_in(int view, Reprojected r, vec2 at, float w, out bool is_beside) {
  is_beside = false;
  float count = clamp(ceil(rate_of(view, r.ratio) / SUBPIXEL_WIDTH), 1.0, MAX_SUBPIXELS);
  if (count == 1.0) return interpolated(view, r, at, is_beside);
  vec4 sum = vec4(0.0);
  for (float nth = 0.0; nth < count * count; nth++) {
    vec2 sub = at + ((vec2(mod(nth, count), floor(nth / count)) + 0.5) / count - 0.5) * float(subpixels);
    Reprojected there = reproject(view, sub, w);
    if (there.inside) sum += interpolated(view, there, sub, is_beside);
  }
  return sum / (count * count);
}

/** Adds what all views but the first show, the best first, until the pixel is covered. */
void add_others(int first, vec2 at, float w, vec2 slope, inout vec4 sum, inout float coverage) {
  vec4 best[MOST_VIEWS];
  float weights[MOST_VIEWS];
  for (int nth = 0; nth < MOST_VIEWS; nth++) weights[nth] = 0.0;
  for (int view = 0; view < view_count; view++) {
    Reprojected r = reproject(view, at, w);
    if (view == first || !r.inside) continue;
    float weight = weight_on_surface(view, r.ratio, at, w, slope);
    if (weight <= weights[MOST_VIEWS - 1]) continue;
    bool is_beside;
    vec4 found = color_in(view, r, at, w, is_beside);
    if (found.a < 1e-3) continue;
    if (is_beside) found *= BESIDE_EDGE;
    float kept = weight * (is_beside ? -1.0 : 1.0);
    for (int nth = 0; nth < MOST_VIEWS; nth++) {
      if (abs(kept) <= abs(weights[nth])) continue;
      float moved = weights[nth];
      vec4 moved_color = best[nth];
      weights[nth] = kept;
      best[nth] = found;
      kept = moved;
      found = moved_color;
    }
  }
  for (int nth = 0; nth < MOST_VIEWS; nth++) {
    if (weights[nth] == 0.0 || coverage >= FULL_COVERAGE) break;
    sum += best[nth] * abs(weights[nth]);
    coverage += best[nth].a / (weights[nth] < 0.0 ? BESIDE_EDGE : 1.0);
  }
}

/** The color of a surface, at a place of the depth buffer, whose nearest sample a pixel of it shows. */
vec3 surface_color(ivec2 source, vec2 at, float w, bool is_alone) {
  vec4 nearest = texelFetch(own, clamp(source, ivec2(0), textureSize(own, 0) - 1), 0);
  int first = int(nearest.a * 255.0 + 0.5);
  vec4 sum = vec4(0.0);
  float coverage = 0.0;
  bool is_beside = false;
  Reprojected r = reproject(min(first, view_count - 1), at, w);
  if (r.inside && first < view_count) sum = color_in(first, r, at, w, is_beside);
  coverage = sum.a;
  if (coverage >= FULL_COVERAGE) return sum.rgb / sum.a;
  vec2 slope = is_alone ? slope_around(source) : vec2(0.0);
  sum *= weight_on_surface(min(first, view_count - 1), r.ratio, at, w, slope) * (is_beside ? BESIDE_EDGE : 1.0);
  add_others(first, at, w, slope, sum, coverage);
  if (coverage < MIN_COVERAGE) {
    float lack = coverage > 0.0 ? (MIN_COVERAGE - coverage) * OWN_SHARE * sum.a / coverage : 1.0;
    sum += vec4(decoded(nearest.rgb), 1.0) * lack;
  }
  return sum.rgb / sum.a;
}

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * subpixels;
  // The surfaces of the pixel: sums of place, inverse depth and share, the inverse depth and the source of each that was found first.
  vec4 parts[MOST_PARTS];
  float first_w[MOST_PARTS];
  ivec2 sources[MOST_PARTS];
  int count = 0;
  float shown = 0.0;
  for (int nth = 0; nth < subpixels * subpixels; nth++) {
    ivec2 pixel = first + ivec2(nth % subpixels, nth / subpixels);
    uvec4 found = texelFetch(surfaces, pixel, 0);
    float share = uintBitsToFloat(found.z);
    if (uintBitsToFloat(found.x) < 0.0) continue;
    for (int side = 0; side < 2; side++) {
      float w = uintBitsToFloat(side == 0 ? found.x : found.y);
      float part = side == 0 ? share : 1.0 - share;
      if (w < 0.0 || part <= 0.0) continue;
      int same = 0;
      for (; same < count; same++) {
        if (min(first_w[same], w) >= max(first_w[same], w) * surface_ratio) break;
      }
      if (same == MOST_PARTS) continue;
      if (same == count) {
        int around = int(side == 0 ? found.w / 25u : found.w % 25u);
        first_w[same] = w;
        sources[same] = pixel + ivec2(around % 5, around / 5) - 2;
        parts[same] = vec4(0.0);
        count++;
      }
      shown += part;
      parts[same] += part * vec4(vec2(pixel), w, 1.0);
    }
  }
  float farthest = 1e30;
  for (int nth = 0; nth < count; nth++) farthest = min(farthest, parts[nth].z / parts[nth].w);
  float before = 0.0;
  for (int nth = 0; nth < count; nth++) before += parts[nth].z / parts[nth].w > farthest ? parts[nth].w : 0.0;
  bool shows_front = count > 1 && 2.0 * before >= shown;
  Pixel pixel = Pixel(vec3(0.0), min(shown / float(subpixels * subpixels), 1.0), -1.0, HOLE_KIND);
  float largest = 0.0;
  for (int nth = 0; nth < count; nth++) {
    vec3 middle = parts[nth].xyz / parts[nth].w;
    pixel.color += parts[nth].w / shown * surface_color(sources[nth], middle.xy, middle.z, count == 1);
    bool is_front = count > 1 && middle.z > farthest;
    if (parts[nth].w > largest && (is_front || !shows_front) && pixel.share >= LEAST_SHOWN) {
      largest = parts[nth].w;
      pixel.w = middle.z;
      pixel.kind = SHOWN_KIND;
    }
  }
  picture = pack(pixel);
}
`;

/** The same without looking anything up, for coarse pictures of few samples: what the nearest sample shows. */
export const NEAREST = `${PRECISE}
out uvec4 picture;
uniform sampler2D own;
${DEPTHS}
${DECODE}
${PIXEL_CODE}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float w = depth_or_fringe_at(at);
  Pixel pixel = Pixel(vec3(0.0), 0.0, -1.0, HOLE_KIND);
  if (w >= 0.0) pixel = Pixel(decoded(texelFetch(own, at, 0).rgb), 1.0, w, SHOWN_KIND);
  picture = pack(pixel);
}
`;
