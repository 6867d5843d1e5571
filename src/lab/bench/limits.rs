//! The machine's limits: how fast memory can be read, and projected points put into a picture by depth.
//!
//! ```text
//! read     sum of a buffer that no cache holds                                           ─▶ GB/s
//! scatter  (random pixel, key) pairs ─ max ─▶ one picture of keys per thread, never merged  ─▶ million points/s
//! copy     from one buffer of the graphics adapter to another, where it is measured        ─▶ GB/s
//! ```
//!
//! None includes work of the method. Every splatting renderer has to scatter at least, without unprojection, projection, colors
//! or merging.

use std::collections::BTreeMap;
use std::hint::black_box;

use rayon::prelude::*;

use super::case::Bench;
use super::measure::{Times, repeat};
use super::report::Limit;
use overlook_engine::error::Result;
use overlook_engine::random::mix;
use overlook_engine::render::gpu::{AdapterChoice, GpuCopy};

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
const SUMS: usize = 16;

/// Measures limits; all measurements count together.
pub(crate) struct LimitMeter {
    numbers: Vec<u64>,
    points: ScatterPoints,
    gpu_copy: Option<GpuCopy>,
    /// Of reading, scattering and copying, by thread count.
    times: BTreeMap<usize, [Times; 3]>,
}

impl LimitMeter {
    /// Prepares `points` to be scattered into a picture of `pixels`, and a copy on the graphics adapter if it is measured.
    pub(crate) fn new(points: u64, pixels: usize, with_gpu: bool, quick: bool) -> Result<Self> {
        let (numbers, bytes) =
            if quick { (READ_NUMBERS_QUICK, COPY_BYTES_QUICK) } else { (READ_NUMBERS, COPY_BYTES) };
        Ok(Self {
            // Written, not only reserved: the system backs untouched memory with one page of zeros.
            numbers: (0..numbers as u64).collect(),
            points: ScatterPoints::random(points, pixels),
            gpu_copy: with_gpu.then(|| GpuCopy::new(AdapterChoice::Any, bytes)).transpose()?,
            times: BTreeMap::new(),
        })
    }

    /// Measures every limit with the threads of the current pool.
    pub(crate) fn measure(&mut self, bench: &Bench<'_>) -> Result<()> {
        let measured = [
            repeat(bench.budget, bench.job, || Ok(sum(black_box(&self.numbers))))?,
            self.points.scatter(bench)?,
            match &self.gpu_copy {
                Some(copy) => repeat(bench.budget, bench.job, || copy.copy())?,
                None => Times::default(),
            },
        ];
        let all = self.times.entry(rayon::current_num_threads()).or_default();
        for (all, times) in all.iter_mut().zip(measured) {
            *all = std::mem::take(all).and(times);
        }
        Ok(())
    }

    /// The limits at the given thread count, at which they were measured.
    pub(crate) fn limit(&self, threads: usize) -> Limit {
        let [read, scatter, copy] = &self.times[&threads];
        Limit {
            threads,
            read_gb_per_s: read.gb_per_s(size_of_val(self.numbers.as_slice()) as u64),
            scatter_mpts_per_s: scatter.millions_per_s(self.points.keys.len() as u64),
            gpu_copy_gb_per_s: self.gpu_copy.as_ref().map(|gpu| copy.gb_per_s(gpu.bytes())),
        }
    }
}

/// The sum of all numbers, by all threads of the current pool.
fn sum(numbers: &[u64]) -> u64 {
    let shares = numbers.par_chunks(READ_SHARE).map(|share| {
        let mut lanes = [0_u64; SUMS];
        let (groups, rest) = share.as_chunks::<SUMS>();
        for group in groups {
            for (lane, number) in lanes.iter_mut().zip(group) {
                *lane = lane.wrapping_add(*number);
            }
        }
        lanes.iter().chain(rest).fold(0, |sum: u64, number| sum.wrapping_add(*number))
    });
    shares.reduce(|| 0, u64::wrapping_add)
}

/// Projected points: the pixel of each, and its key; at a pixel the largest key wins.
#[derive(Debug, PartialEq)]
struct ScatterPoints {
    pixels: Vec<u32>,
    keys: Vec<u64>,
    /// Pixels of the picture.
    picture: usize,
}

impl ScatterPoints {
    /// `count` points on random pixels with random keys, the same in every run.
    fn random(count: u64, picture: usize) -> Self {
        let pixel = |index: u64| (((mix(2 * index) >> 32) * picture as u64) >> 32) as u32;
        let (pixels, keys) = (0..count).map(|index| (pixel(index), mix(2 * index + 1))).unzip();
        Self { pixels, keys, picture }
    }

    /// Times of scattering them, each thread an equal share into a picture of its own.
    fn scatter(&self, bench: &Bench<'_>) -> Result<Times> {
        let threads = rayon::current_num_threads();
        let share = self.pixels.len().div_ceil(threads).max(1);
        let mut pictures = vec![vec![0_u64; self.picture]; threads];
        repeat(bench.budget, bench.job, || {
            let shares = black_box(self).pixels.par_chunks(share).zip(self.keys.par_chunks(share));
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

#[cfg(test)]
mod tests {
    use super::*;

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
        let points = ScatterPoints::random(4000, 100);
        assert_eq!(points, ScatterPoints::random(4000, 100));
        for pixel in 0..100 {
            let hits = points.pixels.iter().filter(|found| **found == pixel).count();
            assert!((10..90).contains(&hits), "{hits} of 40 on pixel {pixel}");
        }
    }
}
