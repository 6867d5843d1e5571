//! What the tree of spans promises, on analytic scenes and on random readings whose right answer is known.

use std::sync::Arc;

use crate::draws::Draws;
use crate::scene::{Scene, arc, camera};
use glam::{DVec3, Vec3};
use half::f16;
use overlook_engine::capture::{Capture, Frame, INVALID_INVERSE_DEPTH, Values};
use overlook_engine::color;
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::preprocess::noise::CameraNoise;
use overlook_engine::preprocess::temporal::PixelClass;
use overlook_engine::preprocess::temporal::{BATCH, FinishedSpans, Split, StaticTest};
use overlook_engine::preprocess::{
    BufferedResult, Preprocessed, inspect_frame, preprocess, preprocess_buffered, scan,
};
use overlook_engine::samples::Span;
use overlook_engine::settings::{Precision, PruningMethod, Settings, SpanLevels};
use overlook_engine::store::file::Extras;
use proptest::prelude::*;

fn with_levels(levels: SpanLevels) -> Settings {
    let mut settings = Settings::default();
    settings.spans.levels = levels;
    settings
}

fn run(capture: &Capture, levels: SpanLevels) -> Preprocessed {
    preprocess(capture, &with_levels(levels), &Job::new()).unwrap()
}

/// Values of a color channel. Of the first three, neighbors are within the tolerance, the first and last are not. The third is of another
/// class of brightness than the first two, 128 of 8-bit sRGB and above.
const CHANNEL: [f32; 4] = [0.2108, 0.2155, 0.2203, 0.6];

/// Inverse depths: none; infinity; three whose neighbors are within the tolerance, but not the first and last; one far from them.
const INVERSE_DEPTH: [f32; 6] = [INVALID_INVERSE_DEPTH, 0.0, 0.5, 0.499_65, 0.499_3, 0.25];

/// Pictures of `width` pixels in which a channel of a pixel or its depth changes now and then, and its normal always.
fn readings(width: usize, frames: usize, seed: u64) -> Vec<Arc<Frame>> {
    let mut draws = Draws(seed);
    let mut below = |bound: u64| draws.below(bound) as usize;
    let mut color: Vec<[usize; 3]> = (0..width).map(|_| std::array::from_fn(|_| below(4))).collect();
    let mut depth: Vec<usize> = (0..width).map(|_| below(6)).collect();
    let mut normal = vec![[0.0; 3]; width];
    (0..frames)
        .map(|_| {
            for pixel in 0..width {
                match below(24) {
                    channel @ 0..3 => color[pixel][channel] = below(4),
                    3 => depth[pixel] = below(6),
                    _ => {}
                }
                let direction =
                    Vec3::from([0.3, 0.01, 1.0].map(|share| share * (below(2001) as f32 - 1000.0)));
                normal[pixel] = direction.normalize_or_zero().to_array();
            }
            let colors = color.iter().map(|color| color.map(|level| f16::from_f32(CHANNEL[level])));
            let depths = depth.iter().map(|&level| INVERSE_DEPTH[level]);
            Arc::new(Frame {
                color: Grid::from_vec(width, 1, colors.collect()),
                inverse_depth: Grid::from_vec(width, 1, depths.collect()),
                normal_in_world: Some(Grid::from_vec(width, 1, normal.clone())),
                depth_step_relative: 0.0,
                values: Values::default(),
            })
        })
        .collect()
}

fn split(frames: &[Arc<Frame>], batch: usize, noise: &CameraNoise) -> FinishedSpans {
    let test = StaticTest::new(&with_levels(SpanLevels::Tree).spans, noise, 0.0, frames.len());
    let mut split = Split::new(frames[0].inverse_depth.len(), frames.len(), test);
    let mut given: FinishedSpans = frames.chunks(batch).flat_map(|frames| split.add(frames)).collect();
    given.sort_by_key(|(span, _)| *span);
    given
}

/// Whether a pixel is static over a span by definition, from all its readings.
fn is_static(frames: &[Arc<Frame>], span: Span, pixel: usize) -> bool {
    let frames = &frames[span.start as usize..span.end as usize];
    let tolerances = Settings::default().spans;
    let depths = || frames.iter().map(|frame| frame.inverse_depth.as_slice()[pixel]);
    let (near, far) = (depths().fold(0.0, f32::max), depths().fold(f32::INFINITY, f32::min));
    let color_range = |channel: usize| {
        let steps =
            || frames.iter().map(|frame| color::steps_from_linear(frame.color.as_slice()[pixel][channel]));
        steps().fold(0.0, f32::max) - steps().fold(f32::INFINITY, f32::min)
    };
    depths().all(|w| w >= 0.0)
        && (near == far || (near - far) / near <= tolerances.depth_tolerance)
        && (0..3).map(color_range).fold(0.0, f32::max) <= tolerances.color_tolerance
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn at_every_frame_each_pixel_with_depth_is_represented_exactly_once(
        width in 1_usize..700, count in 1_usize..70, seed in any::<u64>(),
    ) {
        let frames = readings(width, count, seed);
        let mut holds = vec![0_u32; width * count];
        for (span, samples) in split(&frames, BATCH, &CameraNoise::default()) {
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
        let tree = overlook_engine::preprocess::temporal::SpanTree::new(count, SpanLevels::Tree);
        for (span, samples) in split(&frames, BATCH, &CameraNoise::default()) {
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
        // Classes of brightness that are unlike each other: what is granted depends on where a color is.
        let color_steps = std::array::from_fn(|class| if class % 2 == 0 { 3.0 } else { 0.0 });
        let noise = CameraNoise { color_steps, color_steps_overall: 3.0, depth_relative: 1e-3 };
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
    let samples: usize = split(&still, BATCH, &CameraNoise::default()).iter().map(|(_, s)| s.len()).sum();
    assert!(samples <= with_depth * 2 * 10, "{samples} samples of {with_depth} pixels");
}

/// The largest difference between what a sample says and what its camera recorded, over all frames of the sample's span,
/// 8-bit sRGB steps.
fn worst_error_steps(capture: &Capture, result: &Preprocessed) -> f32 {
    let mut worst = 0.0_f32;
    for image in &result.samples.images {
        for frame in image.span.start..image.span.end {
            let recorded = capture.frame(image.camera as usize, frame as usize).unwrap();
            for sample in image.samples() {
                let pairs = image.color[sample.index].iter().zip(&recorded.color[(sample.x, sample.y)]);
                for (said, seen) in pairs {
                    let [said, seen] = [said, seen].map(|value| color::steps_from_linear(*value));
                    worst = worst.max((said - seen).abs());
                }
            }
        }
    }
    worst
}

/// Every sample lies where its camera saw the surface in each frame of its span.
fn assert_geometry_stays(capture: &Capture, result: &Preprocessed) {
    for image in &result.samples.images {
        let depths = image.inverse_depths();
        for frame in image.span.start..image.span.end {
            let recorded = capture.frame(image.camera as usize, frame as usize).unwrap();
            for sample in image.samples() {
                assert_eq!(depths[sample.index], recorded.inverse_depth[(sample.x, sample.y)]);
            }
        }
    }
}

fn is_red(color: [f16; 3]) -> bool {
    color[0].to_f32() > 0.6 && color[1].to_f32() < 0.25
}

#[test]
fn slow_drift_below_any_step_between_frames_never_carries_a_sample_past_the_tolerance() {
    let mut scene = Scene::still_life();
    // 0.2 of an 8-bit step each frame, 8 steps over the shot.
    scene.ground_light = Some(Arc::new(|frame, _| 0.0012 * frame as f32));
    let capture = scene.record(arc(1, 32), 40);
    let result = run(&capture, SpanLevels::Tree);
    let tolerance = Settings::default().spans.color_tolerance;
    let worst = worst_error_steps(&capture, &result);
    // A drift as even as this looks like noise of a tenth of a step, which is granted on top.
    assert!((0.2..=2.0 * tolerance).contains(&worst), "{worst}");
    let longest = result.samples.images.iter().filter(|image| image.span.len() > 1).map(|image| image.len());
    assert!(longest.sum::<usize>() > 0 && result.samples.sample_count() < 32 * 32 * 20);
}

#[test]
fn an_object_that_rests_and_leaves_is_stored_for_its_rest_and_leaves_no_ghost() {
    let mut scene = Scene::still_life();
    scene.spheres[0].center = Arc::new(|frame| (frame < 14).then_some(DVec3::new(0.0, 0.0, 0.6)));
    let capture = scene.record(arc(3, 48), 16);
    let samples = run(&capture, SpanLevels::Tree).samples;
    for frame in 0..16 {
        let red = samples.images_at(frame).flat_map(|image| image.color.iter());
        let red = red.filter(|color| is_red(**color)).count();
        assert_eq!(red > 0, frame < 14, "frame {frame}: {red} samples of the sphere");
    }
    let spans: Vec<Span> = samples
        .images
        .iter()
        .filter(|image| image.color.iter().any(|color| is_red(*color)))
        .map(|image| image.span)
        .collect();
    let rests = [(0, 8), (8, 12), (12, 14)].map(|(start, end)| Span { start, end });
    assert!(spans.iter().all(|span| rests.contains(span)) && spans.contains(&rests[0]), "{spans:?}");
}

#[test]
fn a_moving_shadow_shortens_spans_where_it_passes_and_leaves_the_wall_where_it_is() {
    let mut scene = Scene::still_life();
    scene.ground_light = Some(Arc::new(|frame, point| {
        if (point.x - 0.25 * frame as f64 + 2.0).abs() < 0.3 && point.y < -0.8 { -0.1 } else { 0.0 }
    }));
    let capture = scene.record(arc(2, 64), 16);
    let (paper, tree) = (run(&capture, SpanLevels::Paper), run(&capture, SpanLevels::Tree));
    assert!(tree.report.samples_kept * 3 < paper.report.samples_kept * 2);
    assert!(worst_error_steps(&capture, &tree) <= Settings::default().spans.color_tolerance);
    assert_eq!(tree.report.cameras[0].background_pixels, paper.report.cameras[0].background_pixels);
    let settings = with_levels(SpanLevels::Tree);
    let scan = scan(&capture, &settings, &Job::new()).unwrap();
    let inspection = inspect_frame(&capture, Some(&scan), &settings, 8, &Job::new()).unwrap();
    assert_geometry_stays(&capture, &tree);
    let seen = &inspection.cameras[0];
    for (pixel, class) in seen.class.as_slice().iter().enumerate() {
        let shade = |frame: usize| capture.frame(0, frame).unwrap().color.as_slice()[pixel];
        let is_passed = (1..16).any(|frame| shade(frame) != shade(0));
        assert_eq!(*class != PixelClass::Background, is_passed, "pixel {pixel}");
    }
    let lasting = seen.class.as_slice().iter().filter(|class| **class == PixelClass::Lasting).count();
    assert!(lasting > 64, "{lasting}");
    assert_eq!(inspection.path.len(), 5);
    for (pixel, level) in seen.level.as_slice().iter().enumerate() {
        let expected = match usize::from(*level) {
            0 => PixelClass::Background,
            4 => PixelClass::Foreground,
            _ => PixelClass::Lasting,
        };
        assert_eq!(seen.class.as_slice()[pixel], expected);
    }
}

#[test]
fn monte_carlo_noise_is_measured_from_a_few_frames_and_leaves_a_still_scene_still() {
    let scene = Scene { color_noise: 0.02, ..Scene::still_life() };
    let capture = scene.record(arc(2, 64), 24);
    let noisy = run(&capture, SpanLevels::Tree);
    let share = noisy.report.cameras[0].background_pixels as f64 / 4096.0;
    assert!(share > 0.99, "{share}");
    let clean = Scene::still_life().trace(&arc(2, 64)[0], 0, 0);
    let background = &noisy.samples.images[0];
    let errors: Vec<f32> = background
        .samples()
        .map(|sample| {
            background.color[sample.index][0].to_f32() / clean.color[(sample.x, sample.y)][0].to_f32()
        })
        .collect();
    let deviation = (errors.iter().map(|e| (e - 1.0).powi(2)).sum::<f32>() / errors.len() as f32).sqrt();
    // 0.02 / √24, and the rounding of half floats.
    assert!((0.003..0.006).contains(&deviation), "{deviation}");
    let facts = &noisy.report.cameras[0].ranges;
    assert!(facts.within_color_tolerance < 0.5 && facts.within_color_tolerance_and_noise > 0.99, "{facts:?}");
}

#[test]
fn depth_tolerance_is_never_below_the_step_that_depth_was_rounded_to() {
    let share = |half_depth| {
        let mut scene = Scene { half_depth, ..Scene::still_life() };
        // Less than the 0.004 that half floats tell apart at this distance, and more than the tolerance.
        scene.spheres[0].center = Arc::new(|frame| Some(DVec3::new(0.0, 0.0004 * frame as f64, 0.6)));
        scene.spheres[0].radius = 0.9;
        let capture = scene.record(vec![camera("c", DVec3::new(0.0, -5.5, 0.8), DVec3::Z * 0.6, 48)], 6);
        let mut settings = with_levels(SpanLevels::Tree);
        settings.spans.depth_tolerance = 1e-5;
        let report = preprocess(&capture, &settings, &Job::new()).unwrap().report;
        report.cameras[0].background_pixels as f64 / (48.0 * 48.0)
    };
    let (half, exact) = (share(true), share(false));
    assert!(half > 0.99 && exact < 0.95, "half {half}, exact {exact}");
}

#[test]
fn a_camera_that_runs_late_disturbs_what_moves_and_nothing_else() {
    let ball = |late: usize| {
        let mut scene = Scene::still_life();
        scene.spheres[1].center =
            Arc::new(move |frame| Some(DVec3::new(0.2 * (frame + late) as f64 - 1.0, -0.6, 0.4)));
        scene
    };
    let cameras = arc(2, 48);
    let [in_time, late] = [0, 2].map(|late| ball(late).record(cameras.clone(), 8));
    let mixed = Capture::new(
        overlook_engine::capture::CaptureParts {
            name: "late".to_owned(),
            cameras: cameras.clone(),
            frame_numbers: (0..8).collect(),
            up_in_world: DVec3::Z,
            has_normals: true,
            antialiased_color: false,
            warnings: Vec::new(),
            source: Arc::new(Recordings([in_time.clone(), late])),
        },
        64 << 20,
    );
    let [in_time, mixed] = [in_time, mixed].map(|capture| run(&capture, SpanLevels::Tree));
    let of = |result: &Preprocessed, camera: usize| {
        let report = &result.report.cameras[camera];
        (report.background_pixels, report.foreground_pixels)
    };
    assert_eq!(of(&in_time, 0), of(&mixed, 0), "the split of a camera is its own affair");
    let (kept, expected) = (mixed.report.samples_kept as f64, in_time.report.samples_kept as f64);
    assert!(kept < 1.35 * expected && kept >= 0.95 * expected, "{kept} against {expected}");
    for frame in 0..8 {
        assert!(mixed.samples.images_at(frame).any(|image| image.camera == 0 && image.span.len() < 8));
    }
}

/// Each camera from a recording of its own.
struct Recordings([Capture; 2]);

impl overlook_engine::capture::FrameSource for Recordings {
    fn load(&self, camera: usize, frame: usize) -> overlook_engine::error::Result<Frame> {
        self.0[camera].frame(camera, frame).map(Arc::unwrap_or_clone)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.0[camera].place(camera, frame)
    }
}

#[test]
fn the_papers_split_is_background_over_all_frames_or_foreground_in_each() {
    let mut scene = Scene::still_life();
    scene.spheres[0].center = Arc::new(|frame| Some(DVec3::new(0.15 * frame as f64 - 0.5, 0.0, 0.6)));
    let capture = scene.record(arc(2, 40), 7);
    let report = run(&capture, SpanLevels::Paper).report;
    let off = run(&capture, SpanLevels::Off).report;
    for camera in 0..2 {
        let frames: Vec<_> = (0..7).map(|frame| capture.frame(camera, frame).unwrap()).collect();
        let same = |pixel: usize| {
            let color_range = (0..3).map(|channel| {
                let steps = || {
                    frames.iter().map(move |f| color::steps_from_linear(f.color.as_slice()[pixel][channel]))
                };
                steps().fold(0.0, f32::max) - steps().fold(f32::INFINITY, f32::min)
            });
            let depths = || frames.iter().map(|f| f.inverse_depth.as_slice()[pixel]);
            let (near, far) = (depths().fold(0.0, f32::max), depths().fold(f32::INFINITY, f32::min));
            color_range.fold(0.0, f32::max) <= 2.0 && (near == far || (near - far) / near <= 0.001)
        };
        let background = (0..1600).filter(|pixel| same(*pixel)).count() as u64;
        assert_eq!(report.cameras[camera].background_pixels, background);
        assert_eq!(report.cameras[camera].foreground_pixels, 7 * (1600 - background));
        assert_eq!(off.cameras[camera].foreground_pixels, 7 * 1600);
    }
}

#[test]
fn samples_that_do_not_fit_the_memory_wait_in_a_file_and_come_back_the_same() {
    let mut scene = Scene::still_life();
    scene.ground_light = Some(Arc::new(|frame, point| 0.05 * ((2.0 * frame as f64 + point.x).sin() as f32)));
    let capture = scene.record(arc(3, 96), 24);
    let with_memory = |cache| {
        let mut settings = with_levels(SpanLevels::Tree);
        settings.capture.memory = cache;
        (settings.spans.color_tolerance, settings.spans.noise) = (0.0, 0.0);
        settings.pruning.method = PruningMethod::Off;
        preprocess(&capture, &settings, &Job::new()).unwrap().samples
    };
    let (tight, ample) = (with_memory(16), with_memory(4096));
    assert!(tight.sample_count() > 1 << 16, "{} samples: more than a mebibyte", tight.sample_count());
    assert_eq!(tight.images, ample.images);
}

#[test]
fn kept_samples_that_do_not_fit_the_memory_are_stored_as_those_that_do() {
    let mut scene = Scene::still_life();
    scene.ground_light = Some(Arc::new(|frame, point| 0.05 * ((2.0 * frame as f64 + point.x).sin() as f32)));
    let capture = scene.record(arc(3, 96), 24);
    let folder = tempfile::tempdir().unwrap();
    let [from_memory, from_file] = ["memory.ovl", "file.ovl"].map(|name| folder.path().join(name));
    for precision in [Precision::Lossless, Precision::Bits10] {
        let mut settings = with_levels(SpanLevels::Tree);
        (settings.spans.color_tolerance, settings.spans.noise) = (0.0, 0.0);
        settings.pruning.method = PruningMethod::Off;
        settings.capture.memory = 16;
        settings.store.precision = precision;
        let Preprocessed { samples, report, .. } = preprocess(&capture, &settings, &Job::new()).unwrap();
        assert!(samples.bytes() > 1 << 20, "{} bytes: more than a sixteenth of the setting", samples.bytes());
        overlook_engine::store::file::write(&from_memory, &samples, &report.to_json().unwrap(), &Job::new())
            .unwrap();
        let BufferedResult { outline, images, report, .. } =
            preprocess_buffered(&capture, &settings, &Job::new()).unwrap();
        assert!(outline.images.is_empty());
        overlook_engine::store::file::write_spooled(
            &from_file,
            &outline,
            &images,
            &Extras { report: report.to_json().unwrap(), ..Extras::default() },
            &Job::new(),
        )
        .unwrap();
        assert_eq!(std::fs::read(&from_memory).unwrap(), std::fs::read(&from_file).unwrap());
    }
}
