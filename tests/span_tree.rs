//! What the tree of spans promises, on analytic scenes and on random readings whose right answer is known.

mod scene;

use std::sync::Arc;

use glam::DVec3;
use half::f16;
use overlook::capture::{Capture, Frame, INVALID_INVERSE_DEPTH};
use overlook::color;
use overlook::grid::Grid;
use overlook::job::Job;
use overlook::preprocess::noise::Noise;
use overlook::preprocess::split::{BATCH, Given, Split};
use overlook::preprocess::static_test::StaticTest;
use overlook::preprocess::{PixelClass, Preprocessed, Span, inspect_frame, preprocess, scan};
use overlook::settings::{Settings, SpanLevels};
use proptest::prelude::*;
use scene::{Scene, arc, camera};

fn with_levels(levels: SpanLevels) -> Settings {
    let mut settings = Settings::default();
    settings.spans.levels = levels;
    settings
}

fn run(capture: &Capture, levels: SpanLevels) -> Preprocessed {
    preprocess(capture, &with_levels(levels), &Job::new()).unwrap()
}

/// Pictures of `width` pixels in which a pixel shows one of a few values, changes now and then, and is without depth now
/// and then.
fn readings(width: usize, frames: usize, seed: u64) -> Vec<Arc<Frame>> {
    let mut state = seed;
    let mut below = |bound: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % bound
    };
    let mut value: Vec<u64> = (0..width).map(|_| below(4)).collect();
    let frame = |value: &[u64]| Frame {
        color: Grid::from_vec(width, 1, value.iter().map(|v| [f16::from_f32(0.2 * *v as f32); 3]).collect()),
        inverse_depth: Grid::from_vec(
            width,
            1,
            value.iter().map(|v| if *v == 0 { INVALID_INVERSE_DEPTH } else { 0.5 }).collect(),
        ),
        normal_in_world: None,
        depth_step_relative: 0.0,
    };
    (0..frames)
        .map(|_| {
            for value in &mut value {
                if below(6) == 0 {
                    *value = below(4);
                }
            }
            Arc::new(frame(&value))
        })
        .collect()
}

fn split(frames: &[Arc<Frame>], batch: usize, noise: &Noise) -> Given {
    let test = StaticTest::new(&with_levels(SpanLevels::Tree).spans, noise, 0.0, frames.len());
    let mut split = Split::new(frames[0].inverse_depth.len(), frames.len(), test);
    let mut given: Given = frames.chunks(batch).flat_map(|frames| split.add(frames)).collect();
    given.sort_by_key(|(span, _)| *span);
    given
}

/// Whether a pixel is static over a span by definition, from all its readings.
fn is_static(frames: &[Arc<Frame>], span: Span, pixel: usize) -> bool {
    let frames = &frames[span.start as usize..span.end as usize];
    let depths = || frames.iter().map(|frame| frame.inverse_depth.as_slice()[pixel]);
    let steps = || frames.iter().map(|frame| color::steps_from_linear(frame.color.as_slice()[pixel][0]));
    let range = steps().fold(0.0, f32::max) - steps().fold(f32::INFINITY, f32::min);
    depths().all(|w| w >= 0.0) && range <= Settings::default().spans.color_tolerance
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn at_every_frame_each_pixel_with_depth_is_represented_exactly_once(
        width in 1_usize..700, count in 1_usize..70, seed in any::<u64>(),
    ) {
        let frames = readings(width, count, seed);
        let mut holds = vec![0_u32; width * count];
        for (span, samples) in split(&frames, BATCH, &Noise::default()) {
            prop_assert!(samples.pixels.is_sorted_by(|a, b| a < b));
            for pixel in samples.pixels {
                (span.start..span.end).for_each(|frame| holds[frame as usize * width + pixel as usize] += 1);
            }
        }
        for (frame, recorded) in frames.iter().enumerate() {
            for (pixel, w) in recorded.inverse_depth.as_slice().iter().enumerate() {
                prop_assert_eq!(holds[frame * width + pixel], u32::from(*w >= 0.0), "frame {}, pixel {}", frame, pixel);
            }
        }
    }

    #[test]
    fn a_sample_lives_in_the_longest_span_over_which_it_is_static(count in 2_usize..70, seed in any::<u64>()) {
        let frames = readings(20, count, seed);
        let tree = overlook::preprocess::span_tree::SpanTree::new(count, SpanLevels::Tree);
        for (span, samples) in split(&frames, BATCH, &Noise::default()) {
            for pixel in samples.pixels {
                prop_assert!(is_static(&frames, span, pixel as usize));
                if let Some(longer) = tree.parent(span) {
                    prop_assert!(!is_static(&frames, longer, pixel as usize), "{:?} in {:?}", span, longer);
                }
            }
        }
    }

    #[test]
    fn the_split_is_the_same_however_many_frames_are_held_at_a_time(
        count in 1_usize..70, batch in 0_u32..5, seed in any::<u64>(),
    ) {
        let frames = readings(40, count, seed);
        let noise = Noise { color_steps: [3.0; 16], color_steps_overall: 3.0, depth_relative: 1e-3 };
        prop_assert_eq!(split(&frames, 1 << batch, &noise), split(&frames, BATCH, &noise));
    }
}

#[test]
fn a_thousand_frames_take_a_handful_of_spans_a_pixel() {
    let frames = readings(64, 1, 5);
    let mut still: Vec<Arc<Frame>> = (0..1000).map(|_| frames[0].clone()).collect();
    let mut lit = (*frames[0]).clone();
    lit.color = Grid::filled(64, 1, [f16::ONE; 3]);
    still[617] = Arc::new(lit);
    let with_depth = frames[0].inverse_depth.as_slice().iter().filter(|w| **w >= 0.0).count();
    let samples: usize = split(&still, BATCH, &Noise::default()).iter().map(|(_, s)| s.len()).sum();
    assert!(samples <= with_depth * 2 * 10, "{samples} samples of {with_depth} pixels");
}
