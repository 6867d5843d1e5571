//! Which pixels may not be static over two spans together: sixteen at a time, by the bits of their ranges alone. Nearly all are
//! certainly static, and need no exact test.

use super::pixel_stats::{REGISTER_PIXELS, SpanSums, larger, smaller};
use super::staticness::{CHANNELS, StaticTest};
use crate::simd::{self, VectorLoop};

/// Lists the pixels, ascending, whose ranges over both spans need an exact test: all that are not static there, and some that are.
/// Pixels that are closed in both are left out.
pub(crate) fn list_uncertain(sums: [&SpanSums; 2], test: &StaticTest, uncertain: &mut Vec<u16>) {
    uncertain.clear();
    simd::run(StaticnessPrefilter { sums, test, uncertain });
    if !test.value_tolerances().is_empty() {
        add_changing_values(sums, test, uncertain);
    }
}

/// Adds the pixels whose scalar values are not static there.
#[cold]
fn add_changing_values([sums, later]: [&SpanSums; 2], test: &StaticTest, uncertain: &mut Vec<u16>) {
    let changes = |pixel: &usize| {
        let is_static = sums.values.is_static_with(&later.values, *pixel, test.value_tolerances());
        !is_static && (sums.is_open(*pixel) | later.is_open(*pixel))
    };
    uncertain.extend((0..sums.pixels()).filter(changes).map(|pixel| pixel as u16));
    uncertain.sort_unstable();
    uncertain.dedup();
}

struct StaticnessPrefilter<'a> {
    sums: [&'a SpanSums; 2],
    test: &'a StaticTest,
    uncertain: &'a mut Vec<u16>,
}

impl VectorLoop for StaticnessPrefilter<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sums, test, uncertain } = self;
        let pixels = sums[0].pixels();
        for first in (0..pixels).step_by(REGISTER_PIXELS) {
            let all = u32::MAX >> (32 - REGISTER_PIXELS.min(pixels - first));
            let mut which = doubts(sums, test, first).unwrap_or(all);
            while which != 0 {
                uncertain.push((first as u32 + which.trailing_zeros()) as u16);
                which &= which - 1;
            }
        }
    }
}

/// The uncertain ones of the pixels from `first` on, one bit each; nothing where there are fewer than are looked at together.
#[inline(always)]
fn doubts([sums, later]: [&SpanSums; 2], test: &StaticTest, first: usize) -> Option<u32> {
    let (mut low, mut high) = (
        *at::<i16, CHANNELS>(&sums.min_color, 3 * first)?,
        *at::<i16, CHANNELS>(&sums.max_color, 3 * first)?,
    );
    let (later_low, later_high) = (
        at::<i16, CHANNELS>(&later.min_color, 3 * first)?,
        at::<i16, CHANNELS>(&later.max_color, 3 * first)?,
    );
    for i in 0..CHANNELS {
        low[i] = low[i].min(later_low[i]);
        high[i] = high[i].max(later_high[i]);
    }
    let doubtful_color = test.uncertain_colors(&low, &high);
    let farthest: [&[f32; REGISTER_PIXELS]; 2] =
        [at(&sums.min_inverse_depth, first)?, at(&later.min_inverse_depth, first)?];
    let nearest: [&[f32; REGISTER_PIXELS]; 2] =
        [at(&sums.max_inverse_depth, first)?, at(&later.max_inverse_depth, first)?];
    let doubtful_depth = simd::mask(|i| {
        let farthest = smaller(farthest[0][i], farthest[1][i]);
        let nearest = larger(nearest[0][i], nearest[1][i]);
        // As `relative_range`, without its branches.
        let is_static =
            (farthest == nearest) | ((nearest - farthest) / nearest <= test.granted_depth_at(nearest));
        !((farthest >= 0.0) & is_static)
    });
    let open: [&[bool; REGISTER_PIXELS]; 2] = [at(&sums.is_open, first)?, at(&later.is_open, first)?];
    let (is_open, later_is_open) = (simd::mask(|i| open[0][i]), simd::mask(|i| open[1][i]));
    // What is open in one of them alone becomes its sample.
    Some((doubtful_color | doubtful_depth | is_open ^ later_is_open) & (is_open | later_is_open))
}

/// So many numbers from `first` on.
#[inline(always)]
fn at<T, const COUNT: usize>(plane: &[T], first: usize) -> Option<&[T; COUNT]> {
    plane.get(first..)?.first_chunk()
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;
    use crate::preprocess::noise::CameraNoise;
    use crate::preprocess::temporal::pixel_stats::FrameRun;
    use crate::settings::SpanSettings;

    /// Sums over frames in which every pixel wanders by up to a few tolerances; the last block is not whole, some pixels have
    /// no depth or lie at infinity, some are closed.
    fn sums(seed: u32, pixels: usize, test: &StaticTest) -> SpanSums {
        let mut state = seed;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        let frames: Vec<(Vec<i16>, Vec<f32>)> = (0..4)
            .map(|_| {
                let color = |i: usize| f16::from_f32(0.003 * (1 + i % 400) as f32).to_bits() as i16;
                let colors = (0..3 * pixels).map(|i| color(i / 3) + random(1 + (i as u32 / 3) % 90) as i16);
                let colors = colors.collect();
                let depth = |i: usize, step: u32| match i % 50 {
                    0 => -1.0,
                    1 => 0.0,
                    _ => 0.5 + (i % 3) as f32 * 0.0004 * step as f32,
                };
                (colors, (0..pixels).map(|i| depth(i, random(3))).collect())
            })
            .collect();
        let runs: Vec<FrameRun<'_>> = frames
            .iter()
            .map(|(color, inverse_depth)| FrameRun {
                color,
                inverse_depth,
                normal: &[],
                values: &crate::capture::NO_VALUES,
                first: 0,
            })
            .collect();
        let mut sums = SpanSums::of(&runs, pixels);
        let closed = (0..pixels).filter(|pixel| !sums.is_static(*pixel, test) && pixel % 7 != 0);
        closed.collect::<Vec<_>>().into_iter().for_each(|pixel| sums.close(pixel));
        sums
    }

    #[test]
    fn every_pixel_that_is_not_static_is_in_doubt_and_most_that_are_static_are_not() {
        let noise = CameraNoise { color_steps: [0.7; 16], color_steps_overall: 0.7, depth_relative: 1e-4 };
        let test = StaticTest::new(&SpanSettings::default(), &noise, 0.0, 60);
        let pixels = 2003;
        let (left, right) = (sums(1, pixels, &test), sums(2, pixels, &test));
        let (mut listed, mut doubts) = (Vec::new(), 0);
        for (a, b) in [(&left, &right), (&right, &left), (&left, &left)] {
            list_uncertain([a, b], &test, &mut listed);
            assert!(listed.is_sorted_by(|a, b| a < b));
            let is_listed = |pixel: usize| listed.binary_search(&(pixel as u16)).is_ok();
            for pixel in 0..pixels {
                let matters = a.is_open(pixel) | b.is_open(pixel);
                let is_static = a.is_static_with(b, pixel, &test);
                assert!(is_listed(pixel) || is_static || !matters, "pixel {pixel}");
                doubts += usize::from(is_listed(pixel) && is_static);
            }
        }
        let is_static = (0..pixels).filter(|pixel| left.is_static_with(&right, *pixel, &test)).count();
        assert!(is_static > 500 && doubts < is_static / 4, "{doubts} doubts, {is_static} static");
    }
}
