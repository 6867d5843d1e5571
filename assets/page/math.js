// Vectors are arrays of three numbers. A pose is twelve: the columns of the rotation from camera space (x right, y down, z forward) to
// world space, then the place of the camera. A lens is [width, height, fx, fy, cx, cy] in pixels, pixel centers at +0.5.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);

/** The direction of a vector; `fallback` where it has none. */
export function normalize(a, fallback = [0, 0, 1]) {
  const size = length(a);
  return size > 0 ? scale(a, 1 / size) : fallback;
}

export const axis = (pose, nth) => [pose[3 * nth], pose[3 * nth + 1], pose[3 * nth + 2]];
export const place = (pose) => axis(pose, 3);
export const poseOf = (right, down, forward, at) => [...right, ...down, ...forward, ...at];

/** Camera space to world space, without and with the place of the camera. */
export const turned = (pose, v) => add(add(scale(axis(pose, 0), v[0]), scale(axis(pose, 1), v[1])), scale(axis(pose, 2), v[2]));
export const moved = (pose, v) => add(turned(pose, v), place(pose));
/** World space to camera space, without the place of the camera. */
export const turnedBack = (pose, v) => [dot(axis(pose, 0), v), dot(axis(pose, 1), v), dot(axis(pose, 2), v)];

/** A vector turned about an axis of length 1 by an angle in radians. */
export function rotate(v, about, angle) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  return add(add(scale(v, cos), scale(cross(about, v), sin)), scale(about, dot(about, v) * (1 - cos)));
}

/** A pose turned about an axis through a center. Its axes are made perpendicular again: small turns add up. */
export function turnPose(pose, center, about, angle) {
  const forward = normalize(rotate(axis(pose, 2), about, angle));
  const down = rotate(axis(pose, 1), about, angle);
  const right = normalize(cross(down, forward));
  const at = add(center, rotate(subtract(place(pose), center), about, angle));
  return poseOf(right, cross(forward, right), forward, at);
}

/** A pose at `eye` that looks at `target`, with `up` upward in the picture. */
export function lookAt(eye, target, up) {
  const forward = normalize(subtract(target, eye));
  let right = cross(forward, up);
  if (length(right) < 1e-9) right = cross(forward, Math.abs(forward[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
  right = normalize(right);
  return poseOf(right, cross(forward, right), forward, eye);
}

/** The rotation of a pose as a unit quaternion x, y, z, w, with w not negative. */
export function quaternionOf(pose) {
  const [a, b, c] = [axis(pose, 0), axis(pose, 1), axis(pose, 2)];
  const trace = a[0] + b[1] + c[2];
  let q;
  if (trace > 0) {
    q = [b[2] - c[1], c[0] - a[2], a[1] - b[0], 1 + trace];
  } else if (a[0] >= b[1] && a[0] >= c[2]) {
    q = [1 + a[0] - b[1] - c[2], a[1] + b[0], c[0] + a[2], b[2] - c[1]];
  } else if (b[1] >= c[2]) {
    q = [a[1] + b[0], 1 + b[1] - a[0] - c[2], b[2] + c[1], c[0] - a[2]];
  } else {
    q = [c[0] + a[2], b[2] + c[1], 1 + c[2] - a[0] - b[1], a[1] - b[0]];
  }
  const size = Math.hypot(...q) * (q[3] < 0 ? -1 : 1);
  return q.map((part) => part / size);
}

/** The pose with the rotation of a unit quaternion. */
export function poseFrom([x, y, z, w], at) {
  return poseOf(
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
    at,
  );
}

/** The pose between two: places along a line, directions evenly turned. */
export function between(a, b, share) {
  const [p, q] = [quaternionOf(a), quaternionOf(b)];
  let cosine = p.reduce((sum, part, nth) => sum + part * q[nth], 0);
  const sign = cosine < 0 ? -1 : 1;
  cosine = Math.min(Math.abs(cosine), 1);
  const angle = Math.acos(cosine);
  const [s, t] = angle < 1e-6 ? [1 - share, share]
    : [Math.sin((1 - share) * angle) / Math.sin(angle), Math.sin(share * angle) / Math.sin(angle)];
  const mixed = p.map((part, nth) => s * part + t * sign * q[nth]);
  const size = Math.hypot(...mixed);
  return poseFrom(mixed.map((part) => part / size), add(scale(place(a), 1 - share), scale(place(b), share)));
}

/** The lens for a picture of `width × height` pixels in which all of another lens's picture fits. */
export function fitLens(lens, width, height) {
  const factor = Math.min(width / lens[0], height / lens[1]);
  return [
    width, height, lens[2] * factor, lens[3] * factor,
    width / 2 + (lens[4] - lens[0] / 2) * factor, height / 2 + (lens[5] - lens[1] / 2) * factor,
  ];
}

/** A lens as `times` the columns and rows of its picture have it. */
export const inPixels = (lens, times) => lens.map((part) => part * times);

/** From squares of `side` pixels of one lens into the pixels of another, before the division: the ray of the first corner, its growth by column and row, and the way between both. */
export function carried(from, fromLens, side, to, toLens) {
  const [, , fx, fy, cx, cy] = fromLens;
  const inPicture = (v) => {
    const [x, y, z] = turnedBack(to, v);
    return [toLens[2] * x + toLens[4] * z, toLens[3] * y + toLens[5] * z, z];
  };
  const [a, b, c] = [0, 1, 2].map((nth) => inPicture(axis(from, nth)));
  return {
    corner: [0, 1, 2].map((i) => c[i] - a[i] * cx / fx - b[i] * cy / fy),
    across: a.map((part) => part * side / fx),
    down: b.map((part) => part * side / fy),
    origin: inPicture(subtract(place(from), place(to))),
  };
}
