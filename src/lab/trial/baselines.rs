//! The obvious alternatives, for comparison: fewer samples, chosen without looking at sampling rates.
//!
//! Random thinning and the voxel grid start from all samples, unpruned, and keep a given number. Both are deterministic. The
//! voxel grid is the usual one of point clouds: space is cut into cubes, separately for each span, and each cube keeps the sample
//! nearest to its center, since a centroid is no pixel and cannot be stored as one. Samples at infinity are sorted into cubes of
//! directions.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use overlook_engine::median::{median, median_f32};
use overlook_engine::random::mix;
use overlook_engine::samples::{SampleImage, SampleSet, Span};

/// Keeps `count` samples chosen at random, each with the same chance; all if there are fewer.
pub(super) fn random(set: &SampleSet, count: u64) -> SampleSet {
    thinned(set, count, &|_, _| 0)
}

/// Keeps one sample of each cube, of cubes just small enough that at least `count` stay, and of these `count` at random.
pub(super) fn voxel_grid(set: &SampleSet, count: u64) -> SampleSet {
    if set.sample_count() <= count {
        return set.clone();
    }
    let points: Vec<Vec<SamplePosition>> =
        set.images.par_iter().map(|image| sample_positions(set, image)).collect();
    let (points, reach) = about_their_middle(points);
    let (mut small, mut large) = (1e-5 * reach, reach);
    let mut chosen = first_of_cubes(set, &points, small);
    for _ in 0..HALVINGS {
        if chosen.len() as u64 >= count {
            break;
        }
        large = small;
        small *= 0.5;
        chosen = first_of_cubes(set, &points, small);
    }
    for _ in 0..BISECTIONS {
        let middle = (small * large).sqrt();
        let trial = first_of_cubes(set, &points, middle);
        if (trial.len() as u64) < count {
            large = middle;
        } else {
            (small, chosen) = (middle, trial);
        }
    }
    let mut rank: Vec<Vec<u64>> = set.images.iter().map(|image| vec![1; image.len()]).collect();
    for (image, sample) in chosen {
        rank[image as usize][sample as usize] = 0;
    }
    thinned(set, count, &|image, sample| rank[image][sample])
}

/// Number of times the smallest cubes are halved if they still hold too many samples: down to the resolution of `f64`, so that
/// the search ends for samples at one position.
const HALVINGS: usize = 36;

/// This share of the farthest samples is ignored for the size of the scene, against outliers of depth.
const OUTLYING: f64 = 0.05;

/// Positions relative to the median of the finite ones, so that cubes do not depend on the world's origin, and the largest
/// distance from it along any axis.
fn about_their_middle(mut points: Vec<Vec<SamplePosition>>) -> (Vec<Vec<SamplePosition>>, f64) {
    let finite = |points: &[Vec<SamplePosition>], value: &dyn Fn(DVec3) -> f64| -> Vec<f64> {
        let positions = points.iter().flatten().filter(|position| !position.at_infinity);
        positions.map(|position| value(position.point)).collect()
    };
    let along = |axis: usize| median(&mut finite(&points, &|point| point[axis])).unwrap_or_default();
    let middle = DVec3::from_array([0, 1, 2].map(along));
    for position in points.iter_mut().flatten().filter(|position| !position.at_infinity) {
        position.point -= middle;
    }
    let mut distances = finite(&points, &|point| point.abs().max_element());
    let nth = ((distances.len() as f64 * (1.0 - OUTLYING)) as usize).min(distances.len().saturating_sub(1));
    let reach = (!distances.is_empty()).then(|| *distances.select_nth_unstable_by(nth, f64::total_cmp).1);
    // Sky samples are on a sphere of radius 1; if all samples are at one position, any cube does.
    (points, reach.filter(|reach| *reach > 0.0).unwrap_or(1.0))
}

/// Resolves cube sizes to 0.3 % over five decades.
const BISECTIONS: usize = 12;

/// Keeps the `count` samples of the lowest rank, by chance among equals.
fn thinned(set: &SampleSet, count: u64, rank: &dyn Fn(usize, usize) -> u64) -> SampleSet {
    let mut keys: Vec<(u64, u64, u32, u32)> = Vec::with_capacity(set.sample_count() as usize);
    for (index, image) in set.images.iter().enumerate() {
        for sample in 0..image.len() {
            let chance = mix(mix(index as u64) ^ sample as u64);
            keys.push((rank(index, sample), chance, index as u32, sample as u32));
        }
    }
    let count = (count as usize).min(keys.len());
    if count < keys.len() {
        keys.select_nth_unstable(count);
    }
    let mut keep: Vec<Vec<bool>> = set.images.iter().map(|image| vec![false; image.len()]).collect();
    for (_, _, image, sample) in &keys[..count] {
        keep[*image as usize][*sample as usize] = true;
    }
    let images = set
        .images
        .par_iter()
        .zip(&keep)
        .map(|(image, keep)| Arc::new(image.part(image.span, |sample, _| keep[sample.index])));
    SampleSet { images: images.filter(|image| !image.is_empty()).collect(), ..set.clone() }
}

/// The position of a sample.
struct SamplePosition {
    /// In world space; for a sample at infinity a direction, scaled so that cubes cut directions as they cut space.
    point: DVec3,
    at_infinity: bool,
}

/// The positions of all samples of an image, in storage order.
fn sample_positions(set: &SampleSet, image: &SampleImage) -> Vec<SamplePosition> {
    let camera = &set.cameras[image.camera as usize];
    let depths = image.inverse_depths();
    // Directions are cut as finely as surfaces at the middle depth are.
    let mut finite: Vec<f32> = depths.iter().copied().filter(|depth| *depth > 0.0).collect();
    let far = median_f32(&mut finite).map_or(1.0, |inverse_depth| 1.0 / f64::from(inverse_depth));
    let position = |x: usize, y: usize, inverse_depth: f32| {
        let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let ray = camera.intrinsics.ray_in_camera(pixel);
        if inverse_depth == 0.0 {
            let direction = camera.world_from_camera.transform_vector3(ray).normalize_or_zero();
            return SamplePosition { point: direction * far, at_infinity: true };
        }
        let point = if camera.intrinsics.is_orthographic() {
            camera.unproject(pixel, f64::from(inverse_depth).recip())
        } else {
            camera.world_from_camera.transform_point3(ray / f64::from(inverse_depth))
        };
        SamplePosition { point, at_infinity: false }
    };
    image.samples().map(|sample| position(sample.x, sample.y, depths[sample.index])).collect()
}

/// Image and sample index of the sample that each cube keeps, separately for each span.
fn first_of_cubes(set: &SampleSet, points: &[Vec<SamplePosition>], size: f64) -> Vec<(u32, u32)> {
    let mut groups: Vec<(Span, Vec<usize>)> = Vec::new();
    for (index, image) in set.images.iter().enumerate() {
        match groups.last_mut().filter(|(span, _)| *span == image.span) {
            Some((_, group)) => group.push(index),
            None => groups.push((image.span, vec![index])),
        }
    }
    let in_group = |(_, group): &(Span, Vec<usize>)| {
        let mut cubes: HashMap<(bool, [i64; 3]), (f64, u32, u32)> = HashMap::new();
        for &image in group {
            for (sample, position) in points[image].iter().enumerate() {
                let cube = (position.point / size).floor();
                let from_middle = (position.point / size - cube - 0.5).length_squared();
                let key = (position.at_infinity, cube.to_array().map(|side| side as i64));
                let candidate = (from_middle, image as u32, sample as u32);
                let first = cubes.entry(key).or_insert(candidate);
                if candidate < *first {
                    *first = candidate;
                }
            }
        }
        let mut kept: Vec<(u32, u32)> =
            cubes.into_values().map(|(_, image, sample)| (image, sample)).collect();
        kept.sort_unstable();
        kept
    };
    groups.par_iter().flat_map_iter(in_group).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_engine::job::Job;
    use overlook_engine::preprocess::preprocess;
    use overlook_engine::settings::{CaptureSettings, Settings};

    /// Camera, first frame, column and row of every sample.
    fn kept(set: &SampleSet) -> HashSet<(u32, usize, usize, usize)> {
        let of = |image: &Arc<SampleImage>| {
            let (camera, start) = (image.camera, image.span.start as usize);
            image.samples().map(move |sample| (camera, start, sample.x, sample.y)).collect::<Vec<_>>()
        };
        set.images.iter().flat_map(of).collect()
    }

    #[test]
    fn the_voxel_grid_keeps_the_same_samples_wherever_the_worlds_origin_lies() {
        let spec = DemoSpec::new("orrery").cameras(2).frames(1).size((48, 36));
        let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
        let near = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples;
        let mut far = near.as_ref().clone();
        for camera in &mut far.cameras {
            camera.world_from_camera.translation += DVec3::new(2e7, -1e7, 5e6);
        }
        let count = near.sample_count() / 4;
        let [here, there] = [near.as_ref(), &far].map(|set| kept(&voxel_grid(set, count)));
        assert_eq!([here.len() as u64, there.len() as u64], [count; 2]);
        let shared = here.intersection(&there).count() as f64 / count as f64;
        assert!(shared > 0.95, "{shared}");
    }
}
