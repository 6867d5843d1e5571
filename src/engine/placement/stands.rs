//! The places where cameras may stand, and where a camera may look from there.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::capture::{Camera, Intrinsics};

/// About how many places are tried.
const PLACES: usize = 180;

/// Cameras whose neighborhood places are found in: nearest ones to each.
const NEIGHBORS: usize = 8;

/// Where cameras may stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stand {
    /// Where the coarse cameras stand, and between them: on the sphere around what they look at, or in the space between cameras that
    /// look outward.
    Between,
    /// Once around what the coarse cameras look at, as high as these are and as far from the middle, and in all places of
    /// [`Stand::Between`].
    Ring,
    /// In a box: its lowest and its highest coordinates in the world.
    Within([DVec3; 2]),
}

/// The places beside those of the coarse cameras, in a fixed order; `middle` is what these look at.
pub(super) fn places(stand: &Stand, cameras: &[Camera], middle: DVec3, up: DVec3) -> Vec<DVec3> {
    match stand {
        Stand::Between => between(cameras, middle),
        Stand::Ring => [ring(cameras, middle, up), between(cameras, middle)].concat(),
        Stand::Within(corners) => within(*corners),
    }
}

/// Between each camera and its neighbors, by twos and by threes.
fn between(cameras: &[Camera], middle: DVec3) -> Vec<DVec3> {
    let eyes: Vec<DVec3> = cameras.iter().map(Camera::position_in_world).collect();
    let looks_at_middle =
        |camera: &Camera| (middle - camera.position_in_world()).dot(camera.forward_in_world()) > 0.0;
    let is_around = cameras.iter().all(looks_at_middle);
    let mix = |parts: &[(usize, f64)]| {
        let flat: DVec3 = parts.iter().map(|(camera, share)| eyes[*camera] * *share).sum();
        let far: f64 = parts.iter().map(|(camera, share)| eyes[*camera].distance(middle) * share).sum();
        match (flat - middle).try_normalize().filter(|_| is_around) {
            Some(direction) => middle + direction * far,
            None => flat,
        }
    };
    let mut pairs = Vec::new();
    let mut triples = Vec::new();
    for first in 0..eyes.len() {
        let near = nearest(&eyes, first);
        for (at, &second) in near.iter().enumerate().filter(|(_, second)| **second > first) {
            pairs.push((first, second));
            let thirds = near[at + 1..].iter().filter(|third| **third > first);
            triples.extend(thirds.map(|&third| (first, second, third)));
        }
    }
    let steps = (PLACES / pairs.len().max(1)).clamp(1, 9);
    let of_pair = |&(first, second): &(usize, usize)| {
        (1..=steps)
            .map(|step| step as f64 / (steps + 1) as f64)
            .map(|share| mix(&[(first, 1.0 - share), (second, share)]))
            .collect::<Vec<_>>()
    };
    let third = 1.0 / 3.0;
    let of_triple = |&(a, b, c): &(usize, usize, usize)| mix(&[(a, third), (b, third), (c, third)]);
    let mut places = spread(pairs.iter().flat_map(of_pair).collect(), PLACES);
    places.extend(spread(triples.iter().map(of_triple).collect(), PLACES / 2));
    places
}

/// The nearest others, nearest first.
fn nearest(eyes: &[DVec3], of: usize) -> Vec<usize> {
    let mut others: Vec<usize> = (0..eyes.len()).filter(|other| *other != of).collect();
    others
        .sort_by(|a, b| eyes[*a].distance_squared(eyes[of]).total_cmp(&eyes[*b].distance_squared(eyes[of])));
    others.truncate(NEIGHBORS);
    others
}

/// At most so many, evenly out of all.
fn spread(places: Vec<DVec3>, most: usize) -> Vec<DVec3> {
    let count = places.len();
    if count <= most {
        return places;
    }
    (0..most).map(|nth| places[nth * count / most]).collect()
}

/// Circles at the lowest, the middle and the highest elevation of the cameras, as far as their middle distance.
fn ring(cameras: &[Camera], middle: DVec3, up: DVec3) -> Vec<DVec3> {
    let from_middle: Vec<DVec3> = cameras.iter().map(|camera| camera.position_in_world() - middle).collect();
    let count = from_middle.len().max(1) as f64;
    let distance = from_middle.iter().map(|from| from.length()).sum::<f64>() / count;
    let elevation = |from: &DVec3| from.normalize_or_zero().dot(up).clamp(-1.0, 1.0).asin();
    let elevations: Vec<f64> = from_middle.iter().map(elevation).collect();
    let low = elevations.iter().copied().fold(f64::INFINITY, f64::min);
    let high = elevations.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut heights = vec![elevations.iter().sum::<f64>() / count, low, high];
    heights.dedup_by(|a, b| (*a - *b).abs() < 0.02);
    let first = up.any_orthonormal_vector();
    let around = PLACES / heights.len();
    let place = |elevation: f64, nth: usize| {
        let turned = DQuat::from_axis_angle(up, TAU * nth as f64 / around as f64) * first;
        middle + distance * (turned * elevation.cos() + up * elevation.sin())
    };
    heights.iter().flat_map(|&elevation| (0..around).map(move |nth| place(elevation, nth))).collect()
}

/// A lattice whose cells are about as long as wide and high.
fn within([low, high]: [DVec3; 2]) -> Vec<DVec3> {
    let sides = (high - low).max(DVec3::splat(1e-9 * (high - low).max_element().max(1e-9)));
    let cell = (sides.x * sides.y * sides.z / PLACES as f64).cbrt();
    let counts =
        (sides / cell).round().clamp(DVec3::ONE, DVec3::splat(PLACES as f64)).to_array().map(|n| n as usize);
    let at =
        |axis: usize, nth: usize| low[axis] + (high - low)[axis] * (nth as f64 + 0.5) / counts[axis] as f64;
    let mut places = Vec::new();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            places.extend((0..counts[0]).map(|x| DVec3::new(at(0, x), at(1, y), at(2, z))));
        }
    }
    spread(places, 2 * PLACES)
}

/// Directions that are tried from each place, evenly over the sphere.
const DIRECTIONS: usize = 24;

/// Targets of coarse cameras that are tried from each place, at most.
const TARGETS: usize = 12;

/// A turn by the golden angle, radians.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// What cameras look at: what the coarse cameras look at together, and what some of them do, as far off.
pub(super) fn targets(cameras: &[Camera], middle: DVec3) -> Vec<DVec3> {
    let step = cameras.len().div_ceil(TARGETS).max(1);
    let of_camera = |camera: &Camera| {
        let eye = camera.position_in_world();
        eye + camera.forward_in_world() * eye.distance(middle)
    };
    std::iter::once(middle).chain(cameras.iter().step_by(step).map(of_camera)).collect()
}

/// Cameras at a place that look at targets, and into all directions.
pub(super) fn poses(eye: DVec3, targets: &[DVec3], lens: Intrinsics, up: DVec3) -> Vec<Camera> {
    let around = (0..DIRECTIONS).map(|nth| {
        let height = 1.0 - (2 * nth + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (nth as f64 * GOLDEN_ANGLE).sin_cos();
        let across = (1.0 - height * height).sqrt();
        eye + DVec3::new(across * cos, across * sin, height)
    });
    let targets = targets.iter().copied().filter(|target| target.distance(eye) > 0.0);
    targets.chain(around).map(|target| Camera::look_at("", lens, eye, target, up)).collect()
}

/// A camera turned to its left or right about an axis, and up or down, in radians.
pub(super) fn turned(camera: &Camera, up: DVec3, [sideways, upward]: [f64; 2]) -> Camera {
    let DAffine3 { matrix3, translation } = camera.world_from_camera;
    let matrix3 = DMat3::from_axis_angle(up, sideways) * matrix3 * DMat3::from_rotation_x(upward);
    Camera { world_from_camera: DAffine3 { matrix3, translation }, ..camera.clone() }
}
