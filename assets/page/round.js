// How far round things go on beyond what was seen of them, as Overlook's renderer finds it and with its numbers: samples of one surface in line
// with a hole lie on a circle in the plane of the eye, and a line of sight that meets the circle shows the same thing, unless a camera saw through.
//
// Source: P. Parent and S. Zucker, Trace Inference, Curvature Consistency, and Curve Detection, PAMI 1989.

import { RAY_TEST } from "./sky.js";

/** For the stage that fills holes, which knows `marked`, `tolerance`, `DIRECTIONS`, and what a hole sees. */
export const ROUND = `
uniform vec3 first_ray, ray_across, ray_down;
${RAY_TEST}
const int WIDEST_SPACING = 6;
const float JOINED_PX = 8.0;
const float LARGEST_RADIUS = 0.3;
const float ODDS_OF_COVERED = 0.05;
const int MOST_DOUBLINGS = 3;
const float MOST_SKY_OF_COVERED = 0.97;

vec3 point_at(ivec2 at, float w) {
  return (first_ray + ray_across * float(at.x) + ray_down * float(at.y)) / w;
}

/** The inverse depth of a surface; 0 where there is none. */
float surface_at(ivec2 at) {
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, textureSize(marked, 0)))) return 0.0;
  return max(uintBitsToFloat(texelFetch(marked, at, 0).z), 0.0);
}

/** The center of the circle at a pixel beside a hole, and its squared radius, 0 where there is none. */
vec4 section_at(ivec2 at, ivec2 step) {
  float last = surface_at(at);
  int count = 0;
  for (; count < 2 * WIDEST_SPACING; count++) {
    float next = surface_at(at + step * (count + 1));
    if (next == 0.0 || max(next, last) > min(next, last) * tolerance(JOINED_PX)) break;
    last = next;
  }
  int spacing = min(count / 4 * 2, WIDEST_SPACING);
  if (spacing == 0) return vec4(0.0);
  ivec2 places[2] = ivec2[2](at + step * (2 * spacing), at + step * spacing);
  vec3 start = point_at(places[0], surface_at(places[0]));
  vec3 middle = point_at(places[1], surface_at(places[1]));
  vec3 a = point_at(at, surface_at(at)) - start;
  vec3 b = middle - start;
  vec3 normal = cross(a, b);
  float square = dot(normal, normal);
  if (square <= 1.2e-38) return vec4(0.0);
  vec3 from_start = cross(b * dot(a, a) - a * dot(b, b), normal) / (2.0 * square);
  vec3 center = start + from_start;
  float radius_squared = dot(from_start, from_start);
  bool is_round = dot(center - middle, middle) > 0.0;
  bool is_small = radius_squared < LARGEST_RADIUS * LARGEST_RADIUS * dot(middle, middle);
  return is_round && is_small ? vec4(center, radius_squared) : vec4(0.0);
}

/** Whether any camera saw through a line of sight somewhere between two inverse depths. */
bool sees_through(vec2 at, float near, float far) {
  for (int camera = 0; camera < asked_count; camera++) {
    for (int nth = 0; nth < 4; nth++) {
      if (look(camera, at, near - (near - far) / 4.0 * (float(nth) + 0.5)) == 1) return true;
    }
  }
  return false;
}

bool goes_on(vec4 section, ivec2 at) {
  vec3 line = point_at(at, 1.0);
  float along = dot(section.xyz, line);
  float square = dot(line, line);
  float inside = along * along - square * (dot(section.xyz, section.xyz) - section.w);
  float front = along - sqrt(max(inside, 0.0));
  return inside > 0.0 && front > 0.0 && !sees_through(vec2(at), square / front, square / along);
}

/** Things that go on through a pixel, that end before it, and surfaces that tell neither; and the direction of the nearest of the first, or −1. */
ivec4 votes_at(ivec2 at) {
  ivec4 votes = ivec4(0, 0, 0, -1);
  float nearest = 0.0;
  for (int direction = 0; direction < 8; direction++) {
    float w = depths[direction];
    if (distances[direction] >= NONE || w <= 0.0) continue;
    ivec2 step = DIRECTIONS[direction];
    vec4 section = section_at(at + step * counts[direction], step);
    if (section.w == 0.0) {
      votes.z++;
    } else if (!goes_on(section, at)) {
      votes.y++;
    } else {
      votes.x++;
      if (w > nearest) votes.w = direction;
      nearest = max(nearest, w);
    }
  }
  return votes;
}

/** The share of the sky in a pixel, where it is \`without\` round things. */
float sky_share_by(ivec4 votes, float without) {
  float share = votes.w >= 0 ? min(without, MOST_SKY_OF_COVERED) : without;
  float odds = float(1 << clamp(votes.y - votes.z, 0, MOST_DOUBLINGS)) * pow(ODDS_OF_COVERED, float(votes.x));
  float sky = share * odds;
  return odds != 1.0 && sky > 0.0 ? sky / (sky + 1.0 - share) : share;
}
`;
