// The virtual camera: it orbits a pivot, flies, and jumps to where cameras stood. The rules are those of Overlook's live view.

import {
  add, axis, dot, fitLens, length, lookAt, moved, normalize, place, poseOf, rotate, scale, subtract, turnPose, turned,
} from "./math.js";

/** How near to straight up or down orbiting goes, as a cosine, so that up stays up. */
const STEEPEST = 0.985;
/** Place of the first view, as a share of the way from the first camera to the second. */
const HOME_STEP = 0.3;
/** The least and largest distance from the pivot by zooming, in distances from the first camera to it. */
const ZOOM = [1e-5, 1e6];
/** Cameras at their pivot count as this far from it. */
const LEAST_DISTANCE = 1e-12;
/** Silhouettes are found at half a pixel in pictures with fewer pixels per recorded pixel: finer ones interpolate them anyway. */
const FINE_SILHOUETTES = 1.5;
/** The finest picture: its pixels per recorded pixel, along each side. */
const FINEST_AT_REST = 2;

/** From the first camera to what the cameras look at: how large the scene is. */
export function homeDistance(scene) {
  return Math.max(length(subtract(place(scene.cameras[0].world_from_camera), scene.pivot)), LEAST_DISTANCE);
}

export class View {
  constructor(scene) {
    this.scene = scene;
    this.homeDistance = homeDistance(scene);
    this.home();
  }

  /** A step from the first camera toward the second, on their circle about what they look at; with one camera, a step to its side. */
  home() {
    const { cameras, pivot, up } = this.scene;
    const first = subtract(place(cameras[0].world_from_camera), pivot);
    const second = cameras.length > 1 ? subtract(place(cameras[1].world_from_camera), pivot) : rotate(first, up, 0.4);
    const radius = this.homeDistance + (length(second) - this.homeDistance) * HOME_STEP;
    const aside = add(scale(first, (1 - HOME_STEP) / this.homeDistance), scale(normalize(second, [0, 0, 0]), HOME_STEP));
    const eye = scale(normalize(aside, [1, 0, 0]), radius);
    this.pose = lookAt(add(pivot, eye), pivot, up);
    this.pivotDistance = Math.max(radius, LEAST_DISTANCE);
    this.lens = cameras[0].lens;
  }

  /** Where a camera stood, with its lens. */
  atCamera(index) {
    const { world_from_camera: pose, lens } = this.scene.cameras[index];
    this.at(pose, lens);
  }

  /** At a pose, with a lens; the pivot stays as far away as what the cameras look at. */
  at(pose, lens) {
    const way = subtract(this.scene.pivot, place(pose));
    const along = dot(way, axis(pose, 2));
    this.pose = pose;
    this.lens = lens;
    this.pivotDistance = along > 0 ? along : Math.max(length(way), LEAST_DISTANCE);
  }

  pivot() {
    return moved(this.pose, [0, 0, this.pivotDistance]);
  }

  /** Turns about the pivot by angles in radians, to the right and downward as the picture moves. */
  orbit(right, down) {
    const { up } = this.scene;
    this.pose = turnPose(this.pose, this.pivot(), up, -right);
    const forward = axis(this.pose, 2);
    const tilted = rotate(forward, axis(this.pose, 0), -down);
    const steepness = Math.abs(dot(tilted, up));
    if (steepness < STEEPEST || steepness < Math.abs(dot(forward, up))) {
      this.pose = turnPose(this.pose, this.pivot(), axis(this.pose, 0), -down);
    }
  }

  zoomed(distance) {
    const [nearest, farthest] = ZOOM.map((share) => share * this.homeDistance);
    return Math.min(Math.max(distance, Math.min(nearest, this.pivotDistance)), Math.max(farthest, this.pivotDistance));
  }

  /** Goes nearer to the pivot (factor below 1) or farther from it. */
  dolly(factor) {
    const pivot = this.pivot();
    this.pivotDistance = this.zoomed(this.pivotDistance * factor);
    this.moveTo(subtract(pivot, scale(axis(this.pose, 2), this.pivotDistance)));
  }

  /** Goes nearer to a point or farther from it; the point stays where it is on the screen. */
  dollyTo(factor, point) {
    this.moveTo(add(point, scale(subtract(place(this.pose), point), factor)));
    this.pivotDistance = this.zoomed(this.pivotDistance * factor);
  }

  /** Shifts the view sideways: shares of the picture's height, right and down. */
  pan(right, down) {
    const height = this.lens[1] / this.lens[3] * this.pivotDistance;
    this.moveTo(add(place(this.pose), turned(this.pose, [-right * height, -down * height, 0])));
  }

  /** Flies: right, down and forward, in pivot distances. */
  fly(steps) {
    this.moveTo(add(place(this.pose), scale(turned(this.pose, steps), this.pivotDistance)));
  }

  moveTo(at) {
    this.pose = poseOf(axis(this.pose, 0), axis(this.pose, 1), axis(this.pose, 2), at);
  }

  /** The lens of a picture for `width × height` pixels of the screen, as fine as it helps; `quality` below 1 is coarser. */
  pictureLens(width, height, quality) {
    const finest = quality < 1 ? quality : FINEST_AT_REST;
    const shrink = Math.max(Math.min(width / this.lens[0], height / this.lens[1]) / finest, 1);
    const size = [width, height].map((side) => Math.max(Math.round(side / shrink), 1));
    return fitLens(this.lens, size[0], size[1]);
  }

  /** Pixels of the depth buffer along each side of a pixel of a picture at rest. */
  subpixels(lens) {
    const [width, height] = this.lens;
    return Math.max(lens[0] / width, lens[1] / height) < FINE_SILHOUETTES ? 2 : 1;
  }
}
