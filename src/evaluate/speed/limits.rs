//! The machine's own limits, measured in the same run as the stages: how fast memory can be read, and how fast points
//! that are already projected can be put into a picture by depth.
//!
//! ```text
//! read     sum of a buffer that no cache holds                                           ─▶ GB/s
//! copy     from one buffer of the graphics adapter to another, where it is measured        ─▶ GB/s
//! scatter  (pixel, key) pairs ─ max ─▶ one picture of keys per thread, never merged     ─▶ million points/s
//! ```
//!
//! Neither does any work of the method. Scattering is what every splatting renderer does at least, without unprojecting,
//! projecting, colors or merging. *Random* points lie on evenly distributed random pixels, in no order; points in *camera
//! order* are the samples of the scene where they fall in the picture, in the order in which the set holds them.

use std::collections::BTreeMap;
use std::hint::black_box;

use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;

use super::Bench;
use super::measure::{Times, repeat};
use super::scene::Scene;
use crate::capture::Camera;
use crate::error::Result;
use crate::preprocess::SampleSet;
use crate::render::AdapterChoice;
use crate::render::gpu::GpuCopy;

/// Numbers that are summed to measure reading: 256 MiB.
const READ_NUMBERS: usize = 1 << 25;
/// The same where only the working is to be seen: 4 MiB.
const READ_NUMBERS_QUICK: usize = 1 << 19;
/// Bytes that the graphics adapter copies to measure its memory, and where only the working is to be seen.
const COPY_BYTES: u64 = 128 << 20;
const COPY_BYTES_QUICK: u64 = 4 << 20;
/// Numbers that one thread sums in one go: 512 KiB.
const READ_SHARE: usize = 1 << 16;
/// Sums that run side by side, so that no addition waits for the one before.
const LANES: usize = 16;

const SEED: u64 = 2003;

/// What the machine can do at most with some number of threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// Threads.
    pub threads: usize,
    /// Reading memory in sequence, 10⁹ bytes a second.
    pub read_gb_per_s: f64,
    /// Scattering random points into a picture of the size of the scene's cameras, million points a second.
    pub scatter_mpts_per_s: f64,
    /// Scattering the scene's own samples in camera order into the same picture, million points a second.
    pub scatter_camera_order_mpts_per_s: f64,
    /// Copying in the graphics adapter's memory, 10⁹ bytes a second; `None` where no adapter was measured.
    pub gpu_copy_gb_per_s: Option<f64>,
    /// Scattering into each measured size of picture, the cameras' own first.
    pub scatter: Vec<ScatterLimit>,
}

/// What scattering comes to for one size of picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScatterLimit {
    /// Columns of the picture.
    pub width: u32,
    /// Rows of the picture.
    pub height: u32,
    /// Random points, million a second.
    pub random_mpts_per_s: f64,
    /// The scene's samples in camera order, million a second, counting those that fall in the picture.
    pub camera_order_mpts_per_s: f64,
}

impl Limit {
    /// The limit of scattering random points into a picture of this size, million points a second; `None` where it was
    /// not measured.
    #[must_use]
    pub fn scatter_at(&self, width: u32, height: u32) -> Option<f64> {
        let of_size = |limit: &&ScatterLimit| (limit.width, limit.height) == (width, height);
        Some(self.scatter.iter().find(of_size)?.random_mpts_per_s)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Probe {
    Read,
    /// Of the target with this index.
    Random(usize),
    /// Of the target with this index.
    CameraOrder(usize),
    GpuCopy,
}

/// A size of picture and what is scattered into it.
struct Target {
    size: (u32, u32),
    random: Points,
    camera_order: Points,
}

/// Measures limits, as often as asked; all measurements count together.
pub(super) struct LimitMeter {
    numbers: Vec<u64>,
    targets: Vec<Target>,
    gpu_copy: Option<GpuCopy>,
    times: BTreeMap<(usize, Probe), Times>,
}

impl LimitMeter {
    /// For pictures of these sizes, the cameras' own first.
    pub(super) fn new(scene: &Scene, sizes: &[(u32, u32)], quick: bool) -> Self {
        let numbers = if quick { READ_NUMBERS_QUICK } else { READ_NUMBERS };
        let targets = sizes.iter().map(|&size| {
            let [vantage, _] = scene.vantages(size, 0);
            let pixels = vantage.camera.intrinsics.pixel_count();
            Target {
                size,
                random: Points::random(scene.unpruned.sample_count(), pixels),
                camera_order: Points::projected(&scene.unpruned, &vantage.camera),
            }
        });
        // Written, not only reserved: the system backs untouched memory with one page of zeros.
        Self {
            numbers: (0..numbers as u64).collect(),
            targets: targets.collect(),
            gpu_copy: None,
            times: BTreeMap::new(),
        }
    }

    /// Measures the memory of the graphics adapter too.
    ///
    /// # Errors
    /// `Gpu` where there is none.
    pub(super) fn include_gpu(&mut self, quick: bool) -> Result<()> {
        let bytes = if quick { COPY_BYTES_QUICK } else { COPY_BYTES };
        self.gpu_copy = Some(GpuCopy::new(AdapterChoice::Any, bytes)?);
        Ok(())
    }

    /// Measures every limit with the threads of the current pool.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn measure(&mut self, bench: &Bench<'_>) -> Result<()> {
        let threads = rayon::current_num_threads();
        let targets = 0..self.targets.len();
        let scatters = targets.flat_map(|target| [Probe::Random(target), Probe::CameraOrder(target)]);
        let copies = self.gpu_copy.iter().map(|_| Probe::GpuCopy);
        for probe in std::iter::once(Probe::Read).chain(scatters).chain(copies) {
            let times = match probe {
                Probe::Read => repeat(bench.budget, bench.job, || Ok(sum(black_box(&self.numbers)))),
                Probe::Random(target) => self.targets[target].scatter(bench, |target| &target.random),
                Probe::CameraOrder(target) => {
                    self.targets[target].scatter(bench, |target| &target.camera_order)
                }
                Probe::GpuCopy => {
                    repeat(bench.budget, bench.job, || self.gpu_copy.as_ref().map(GpuCopy::copy).transpose())
                }
            }?;
            let earlier = self.times.remove(&(threads, probe)).unwrap_or_default();
            self.times.insert((threads, probe), earlier.and(times));
        }
        Ok(())
    }

    /// The limits at the given thread count; zero where nothing was measured.
    pub(super) fn limit(&self, threads: usize) -> Limit {
        let times = |probe| self.times.get(&(threads, probe)).cloned().unwrap_or_default();
        let scatter: Vec<_> = self
            .targets
            .iter()
            .enumerate()
            .map(|(index, target)| ScatterLimit {
                width: target.size.0,
                height: target.size.1,
                random_mpts_per_s: times(Probe::Random(index)).millions_per_s(target.random.len()),
                camera_order_mpts_per_s: times(Probe::CameraOrder(index))
                    .millions_per_s(target.camera_order.len()),
            })
            .collect();
        let first = scatter.first();
        Limit {
            threads,
            read_gb_per_s: times(Probe::Read).gb_per_s(size_of_val(self.numbers.as_slice()) as u64),
            scatter_mpts_per_s: first.map_or(0.0, |first| first.random_mpts_per_s),
            scatter_camera_order_mpts_per_s: first.map_or(0.0, |first| first.camera_order_mpts_per_s),
            gpu_copy_gb_per_s: self
                .gpu_copy
                .as_ref()
                .map(|copy| times(Probe::GpuCopy).gb_per_s(copy.bytes())),
            scatter,
        }
    }

    /// Share of the unpruned samples that fall in the first size of picture, 0 to 1.
    pub(super) fn in_picture(&self) -> f64 {
        self.targets
            .first()
            .map_or(0.0, |target| target.camera_order.len() as f64 / target.random.len().max(1) as f64)
    }
}

/// The sum of all numbers, by all threads of the current pool.
fn sum(numbers: &[u64]) -> u64 {
    let shares = numbers.par_chunks(READ_SHARE).map(|share| {
        let mut lanes = [0_u64; LANES];
        let (groups, rest) = share.as_chunks::<LANES>();
        for group in groups {
            for (lane, number) in lanes.iter_mut().zip(group) {
                *lane = lane.wrapping_add(*number);
            }
        }
        lanes.iter().chain(rest).fold(0, |sum: u64, number| sum.wrapping_add(*number))
    });
    shares.reduce(|| 0, u64::wrapping_add)
}

/// Projected points: each its pixel, and a key of which the larger wins.
#[derive(Debug, PartialEq)]
struct Points {
    pixels: Vec<u32>,
    keys: Vec<u64>,
}

impl Points {
    fn len(&self) -> u64 {
        self.pixels.len() as u64
    }

    /// `count` points on random pixels with random keys, the same in every run.
    fn random(count: u64, pixels: usize) -> Self {
        let mut state = SEED;
        let pairs = (0..count).map(|_| {
            let pixel = ((splitmix(&mut state) >> 32) * pixels as u64) >> 32;
            (pixel as u32, splitmix(&mut state))
        });
        let (pixels, keys) = pairs.unzip();
        Self { pixels, keys }
    }

    /// The set's samples as `target` sees them, those outside its picture left out.
    fn projected(set: &SampleSet, target: &Camera) -> Self {
        let (width, height) = target.intrinsics.size();
        let mut points = Self { pixels: Vec::new(), keys: Vec::new() };
        for image in &set.images {
            let source = &set.cameras[image.camera as usize];
            let target_from_source = target.camera_from_world() * source.world_from_camera;
            let inverse_depths = image.inverse_depths();
            for sample in image.samples() {
                let center = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
                let ray = source.intrinsics.ray_in_camera(center);
                // Scaled by the inverse depth, so that points at infinity have a place too.
                let inverse_depth = f64::from(inverse_depths[sample.index]);
                let point = target_from_source.matrix3 * ray + target_from_source.translation * inverse_depth;
                let Some(place) = target.intrinsics.project(point) else { continue };
                let (x, y) = (place.x.floor(), place.y.floor());
                if x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64 {
                    let nearness = ((inverse_depth / point.z) as f32).to_bits();
                    points.keys.push(u64::from(nearness) << 32 | points.len());
                    points.pixels.push((y as usize * width + x as usize) as u32);
                }
            }
        }
        points
    }
}

impl Target {
    /// Times of scattering the chosen points, each thread an equal share into a picture of its own.
    fn scatter(&self, bench: &Bench<'_>, choose: impl Fn(&Self) -> &Points) -> Result<Times> {
        let points = choose(self);
        let threads = rayon::current_num_threads();
        let share = points.pixels.len().div_ceil(threads).max(1);
        let mut pictures = vec![vec![0_u64; self.size.0 as usize * self.size.1 as usize]; threads];
        repeat(bench.budget, bench.job, || {
            let pixels = black_box(points).pixels.par_chunks(share);
            let shares = pixels.zip(points.keys.par_chunks(share));
            pictures.par_iter_mut().zip(shares).for_each(|(picture, (pixels, keys))| {
                put(picture, pixels, keys);
            });
            black_box(&mut pictures);
            Ok(())
        })
    }
}

/// Keeps the larger key at every pixel, without a branch on which one that is.
fn put(picture: &mut [u64], pixels: &[u32], keys: &[u64]) {
    for (&pixel, &key) in pixels.iter().zip(keys) {
        if let Some(largest) = picture.get_mut(pixel as usize) {
            *largest = key.max(*largest);
        }
    }
}

/// The next random number.
///
/// Source: Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014 (`SplitMix64`).
fn splitmix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;

    #[test]
    fn the_sum_counts_every_number_once() {
        let count = 3 * READ_SHARE + 5;
        let numbers: Vec<u64> = (0..count as u64).collect();
        assert_eq!(sum(&numbers), (count as u64 - 1) * count as u64 / 2);
    }

    #[test]
    fn the_larger_key_stays() {
        let mut picture = vec![0; 4];
        put(&mut picture, &[1, 3, 1, 3, 9], &[5, 7, 4, 8, 1]);
        assert_eq!(picture, [0, 5, 0, 8]);
    }

    #[test]
    fn random_points_are_the_same_every_time_and_lie_all_over_the_picture() {
        let points = Points::random(4000, 100);
        assert_eq!(points, Points::random(4000, 100));
        for pixel in 0..100 {
            let hits = points.pixels.iter().filter(|found| **found == pixel).count();
            assert!((10..90).contains(&hits), "{hits} of 40 on pixel {pixel}");
        }
    }

    #[test]
    fn projected_points_lie_where_the_camera_that_recorded_them_saw_them() {
        let scene = Scene::new((64, 48), &Job::new()).unwrap();
        let image = &scene.unpruned.images[0];
        let alone = SampleSet { images: vec![image.clone()], ..scene.unpruned.as_ref().clone() };
        let points = Points::projected(&alone, &scene.capture.cameras[image.camera as usize]);
        let expected: Vec<u32> = image.samples().map(|sample| (sample.y * 64 + sample.x) as u32).collect();
        assert_eq!(points.pixels, expected);
    }
}
