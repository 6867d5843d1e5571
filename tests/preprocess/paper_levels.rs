//! The paper's two lengths of spans, all frames and one, against a plain implementation of its own: all readings of every
//! pixel side by side, looked at one pixel at a time. They must agree sample for sample.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::scene::{Scene, Sphere, arc};
use glam::DVec3;
use half::f16;
use overlook_engine::capture::{Capture, Frame};
use overlook_engine::color::steps_from_linear;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::job::Job;
use overlook_engine::preprocess::noise::granted_range_sigmas;
use overlook_engine::preprocess::temporal::TemporalScan;
use overlook_engine::preprocess::{preprocess, scan};
use overlook_engine::samples::Span;
use overlook_engine::settings::{CaptureSettings, PruningMethod, Settings, SpanLevels};

/// By camera, span and pixel: color bits and inverse depth bits.
type Samples = BTreeMap<(usize, Span, usize), ([u16; 3], u32)>;

fn paper() -> Settings {
    let mut settings = Settings::default();
    settings.spans.levels = SpanLevels::Paper;
    settings.pruning.method = PruningMethod::Off;
    settings
}

/// What Overlook gives, pruning left out.
fn ours(capture: &Capture) -> Samples {
    let set = preprocess(capture, &paper(), &Job::new()).unwrap().samples;
    let mut samples = Samples::new();
    for image in &set.images {
        let depths = image.inverse_depths();
        let width = set.cameras[image.camera as usize].intrinsics.width as usize;
        for sample in image.samples() {
            let key = (image.camera as usize, image.span, sample.y * width + sample.x);
            let bits = image.color[sample.index].map(f16::to_bits);
            assert!(samples.insert(key, (bits, depths[sample.index].to_bits())).is_none());
        }
    }
    samples
}

/// The paper's background and foreground: a pixel that remains constant over time belongs to the background, all others to the
/// foreground of their frame. Constant is what stays within the tolerances and what the measured noise
/// explains.
fn plainly(capture: &Capture, scanned: &TemporalScan) -> Samples {
    let (spans, frames) = (paper().spans, capture.frame_count());
    let sigmas = spans.noise * granted_range_sigmas(frames);
    let mut samples = Samples::new();
    for camera in 0..capture.cameras.len() {
        let known = &scanned.cameras[camera];
        let recorded: Vec<Arc<Frame>> = (0..frames).map(|f| capture.frame(camera, f).unwrap()).collect();
        let depth_granted =
            spans.depth_tolerance.max(2.0 * known.depth_step_relative) + sigmas * known.noise.depth_relative;
        for pixel in 0..recorded[0].inverse_depth.len() {
            let colors: Vec<[f16; 3]> = recorded.iter().map(|f| f.color.as_slice()[pixel]).collect();
            let depths: Vec<f32> = recorded.iter().map(|f| f.inverse_depth.as_slice()[pixel]).collect();
            let mean: [f16; 3] = std::array::from_fn(|channel| {
                let sum: f64 = colors.iter().map(|color| f64::from(color[channel].to_f32())).sum();
                f16::from_f32(sum as f32 / frames as f32)
            });
            let ends: [[f32; 2]; 3] = std::array::from_fn(|channel| {
                let steps = colors.iter().map(|color| steps_from_linear(color[channel]));
                [steps.clone().fold(f32::MAX, f32::min), steps.fold(f32::MIN, f32::max)]
            });
            let color_range = ends.map(|[low, high]| high - low).into_iter().fold(0.0, f32::max);
            // At the least noisy brightness that a channel goes through.
            let noise = ends.map(|[low, high]| {
                let between = (0..64).map(|i| low + (high - low) * i as f32 / 64.0).chain([high]);
                between.map(|steps| known.noise.color_at(steps)).fold(f32::MAX, f32::min)
            });
            let color_granted = spans.color_tolerance + sigmas * noise.into_iter().fold(0.0, f32::max);
            let (far, near) = depths.iter().fold((f32::MAX, f32::MIN), |(f, n), w| (f.min(*w), n.max(*w)));
            let depth_range = if near > far { (near - far) / near } else { 0.0 };
            let constant = far >= 0.0 && depth_range <= depth_granted && color_range <= color_granted;
            if constant {
                let exact = depths.iter().map(|w| f64::from(*w)).sum::<f64>() / frames as f64;
                let depth = if near == far { near } else { exact as f32 };
                let all = Span { start: 0, end: frames as u32 };
                samples.insert((camera, all, pixel), (mean.map(f16::to_bits), depth.to_bits()));
                continue;
            }
            for frame in (0..frames).filter(|frame| depths[*frame] >= 0.0) {
                let one = Span { start: frame as u32, end: frame as u32 + 1 };
                let color = colors[frame].map(f16::to_bits);
                samples.insert((camera, one, pixel), (color, depths[frame].to_bits()));
            }
        }
    }
    samples
}

fn assert_agree(capture: &Capture) -> [usize; 2] {
    let scanned = scan(capture, &paper(), &Job::new()).unwrap();
    let (ours, plainly) = (ours(capture), plainly(capture, &scanned));
    for (key, sample) in &plainly {
        assert_eq!(ours.get(key), Some(sample), "{key:?}");
    }
    assert_eq!(ours.len(), plainly.len());
    let background = plainly.keys().filter(|(_, span, _)| span.len() > 1).count();
    [background, plainly.len() - background]
}

#[test]
fn random_captures_are_split_as_a_plain_implementation_splits_them() {
    let mut seen = [0, 0];
    for seed in 0..24_usize {
        let moving = Sphere {
            center: Arc::new(move |frame| {
                ((frame + seed) % 5 != 0).then_some(DVec3::new(
                    -1.0 + 0.3 * (frame * (seed % 3)) as f64,
                    -0.5,
                    0.5,
                ))
            }),
            radius: 0.3 + 0.05 * (seed % 7) as f64,
            color: [0.6, 0.6, 0.1],
        };
        let mut scene = Scene {
            color_noise: [0.0, 0.01, 0.04][seed % 3],
            half_depth: seed % 2 == 1,
            normals: seed % 4 < 2,
            ..Scene::still_life()
        };
        if seed % 5 == 0 {
            scene.ground_light =
                Some(Arc::new(|frame, point| if point.x > 0.0 { 0.004 * frame as f32 } else { 0.0 }));
        }
        scene.spheres.push(moving);
        let capture = scene.record(arc(1 + seed % 3, 11 + seed as u32), 2 + seed % 9);
        let [background, foreground] = assert_agree(&capture);
        seen = [seen[0] + background, seen[1] + foreground];
    }
    assert!(seen.iter().all(|samples| *samples > 1000), "{seen:?}");
}

#[test]
fn built_in_scenes_are_split_as_a_plain_implementation_splits_them() {
    let scenes = [("nine-cameras", 3, 6), ("orrery", 2, 5), ("four-cameras", 2, 5), ("crystal", 2, 6)];
    for (scene, cameras, frames) in scenes {
        let spec = DemoSpec::new(scene).cameras(cameras).frames(frames).size((64, 48));
        let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
        let [background, foreground] = assert_agree(&capture);
        assert!(background > 0 && foreground > 0, "{scene}: {background} and {foreground}");
    }
}
