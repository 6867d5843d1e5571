// The stages that take samples. Pictures are drawn with rows downward, as cameras count them, and turned over at last.
//
//   SEEN      the samples of each camera in a picture of its own, in which they are looked up
//   SURFACE   depth, color and view of the nearest sample of each pixel
//   then those of gather.js, which color it, of sky.js, which tell holes apart, and of fill.js, which fill them and show the picture

/** From a sample to its footprint in the picture: a plane has an inverse depth that is linear in the pixels of any pinhole camera. */
const REACHES = `
precision highp float;
precision highp int;
/** How far a footprint reaches from its sample, in pixels of its camera; and with its fringe, which fills gaps that pruning left. */
const float CORE_REACH = 0.525;
const float FRINGE = 1.0;
`;

const FOOTPRINT = `
${REACHES}
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

/** Samples that are at least this many pixels wide have a fringe. */
const float MAGNIFIED = 2.5;

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

/**
 * Depths in the buffer: nearer is greater, and of four tiers each is behind all of the one before: samples, doubtful ones, and the fringes of
 * both; 0 is nothing.
 */
export const DEPTH_CODE = `
uniform float unit;
const float LEAST_CORE = 0.25;

float code_of(float inverse_depth, int tier) {
  float x = inverse_depth * unit;
  return (0.5 + 0.5 * x / (1.0 + x)) / float(1 << tier);
}

float inverse_depth_of(float code) {
  float x = code * (code < 0.125 ? 16.0 : code < 0.25 ? 8.0 : code < 0.5 ? 4.0 : 2.0) - 1.0;
  return x / ((1.0 - x) * unit);
}
`;

/** Linear colors from sRGB. */
export const DECODE = `
vec3 decoded(vec3 encoded) {
  return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}
`;


export const SURFACE_VERTEX = `#version 300 es
${FOOTPRINT}
uniform float view;
flat out vec2 center;
flat out vec4 inverse;
flat out vec4 plane;
flat out vec4 reach;
flat out int is_doubtful;
flat out vec4 color_view;
void main() {
  Footprint f = footprint();
  mat2 j = f.jacobian;
  float d = determinant(j);
  float i = abs(d) > 1e-6 ? 1.0 / d : 0.0;
  center = f.center;
  inverse = vec4(j[1][1], -j[1][0], -j[0][1], j[0][0]) * i;
  plane = vec4(f.plane, f.deviation);
  color_view = vec4(color_flags.rgb, view / 255.0);
  int flags = int(color_flags.a * 255.0 + 0.5);
  is_doubtful = flags & 1;
  // Toward other samples there is no fringe, and none where the surface is seen edge on.
  bool has_fringe = i != 0.0 && focal_ratio * f.reciprocal >= MAGNIFIED;
  for (int nth = 0; nth < 4; nth++) reach[nth] = has_fringe && (flags >> nth + 1 & 1) == 0 ? FRINGE : CORE_REACH;
  vec2 half_size = max(reach.x, reach.y) * abs(j[0]) + max(reach.z, reach.w) * abs(j[1]);
  place(f, max(0.5, min(max(half_size.x, half_size.y), MAX_STRETCH * focal_ratio * f.reciprocal)));
}
`;

export const SURFACE_FRAGMENT = `#version 300 es
${REACHES}
flat in vec2 center;
flat in vec4 inverse;
flat in vec4 plane;
flat in vec4 reach;
flat in int is_doubtful;
flat in vec4 color_view;
out vec4 own;
${DEPTH_CODE}
void main() {
  vec2 offset = gl_FragCoord.xy - center;
  vec2 camera = vec2(dot(inverse.xy, offset), dot(inverse.zw, offset));
  bool is_core = max(abs(camera.x), abs(camera.y)) <= CORE_REACH || max(abs(offset.x), abs(offset.y)) <= 0.5;
  bool is_fringe = camera.x >= -reach.x && camera.x <= reach.y && camera.y >= -reach.z && camera.y <= reach.w;
  if (!is_core && !is_fringe) discard;
  float most = plane.w * (is_core ? 1.0 : FRINGE / CORE_REACH);
  gl_FragDepth = code_of(max(plane.x + clamp(dot(plane.yz, offset), -most, most), 0.0), is_doubtful + (is_core ? 0 : 2));
  own = color_view;
}
`;

/** A sample as its camera has it: bits of the inverse depth, one more so that 0 is none, and roots of linear colors, ten bits each. */
export const SEEN_VERTEX = `#version 300 es
precision highp float;
layout(location = 0) in vec2 pixel;
layout(location = 1) in float inverse_depth;
layout(location = 3) in vec4 color_flags;
uniform vec2 first, size;
uniform bool is_there;
flat out uvec2 sample_code;
${DECODE}
void main() {
  uvec3 root = uvec3(sqrt(decoded(color_flags.rgb)) * 1023.0 + 0.5);
  sample_code = is_there ? uvec2(floatBitsToUint(inverse_depth) + 1u, root.x | root.y << 10 | root.z << 20) : uvec2(0u);
  gl_Position = vec4((first + pixel + 0.5) / size * 2.0 - 1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}
`;

export const SEEN_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
flat in uvec2 sample_code;
out uvec2 seen;
void main() {
  seen = sample_code;
}
`;

/** One triangle over the whole picture. */
export const WHOLE_VERTEX = `#version 300 es
void main() {
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}
`;
