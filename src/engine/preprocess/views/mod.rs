//! Pruning of a recording: many views of one moment, in memory that does not grow with their number.
//!
//! ```text
//! what each view saw ─▶ pairs that may see the same ─▶ an order in which neighbors come together
//!      └─ groups of views, each with all that may see their samples, within the memory setting:
//!           noise between views ─▶ best candidates ─▶ coverage (until nothing waits) ─▶ pack
//! ```
//!
//! Purpose: all views of a frame are compared with each other, and as layers a hundred of them take gigabytes. A view is compared only
//! with those whose picture may hold any of its samples: of a camera that walks, that is a bounded number. Layers are made of the
//! recorded samples when they are needed, and given up where they take too much memory; verdicts wait in a temporary file. One byte
//! a pixel of every view is held throughout: whether its sample is kept.
//!
//! Source: the order is that of E. Cuthill and J. McKee, *Reducing the Bandwidth of Sparse Symmetric Matrices*, 1969. What is decided
//! does not depend on it, nor on what is held: "better" is a total order of all samples ([`super::pruning`]).

mod looks;
mod neighborhoods;
mod recording;
mod steps;
mod verdict_store;
mod window;

pub(crate) use recording::Views;

use super::diagnostics::{Residuals, RunCounts, Tally};
use super::normals::NormalErrors;
use super::registration::{CameraPairs, Sight};
use crate::error::Result;
use crate::job::Job;
use crate::samples::ImageBuffer;
use crate::settings::AgreementRule;
use looks::{better_reading, noise_between};
use steps::Pruning;
use window::LayerWindow;

/// The largest share of its depth by which averaging noisy cameras moves a sample. Other views take part within 3 √2 standard
/// deviations of the sample; smoothing moves it by at most 3 of them, and at most by half its depth (see [`super::agreement`]).
fn moved_at_most(noise: f32) -> f32 {
    let smoothed = (3.0 * noise).min(0.5);
    (3.0 * std::f32::consts::SQRT_2 * noise).max(smoothed / (1.0 - smoothed))
}

/// Prunes the views of a single frame, and adds what is kept to `images`.
///
/// # Errors
/// `Io` where a temporary file cannot be used, and `Cancelled`.
pub(crate) fn prune_views(
    mut images: ImageBuffer,
    views: Views<'_>,
    normal_errors: &[Vec<NormalErrors>],
    job: &Job,
) -> Result<(ImageBuffer, RunCounts)> {
    let Views { capture, scan, settings, .. } = views;
    job.start("Pruning views", 2 * capture.cameras.len());
    let sights = views.sights(job)?;
    let pairs = CameraPairs::of_sights(&capture.cameras, &sights);
    let mut window = LayerWindow::new(views, &pairs);
    let mut tally = Tally::new(capture, scan, normal_errors, settings);
    if settings.pruning.agreement != AgreementRule::Off {
        let noise = noise_between(&pairs, &mut window, job)?;
        window.set_noise(noise);
    }
    // Samples that are moved may be seen by other views than before.
    let noise = window.most_noise();
    let moved = 1.01 * moved_at_most(noise);
    let pairs = if moved < 1.0 {
        let blurred: Vec<Sight> = sights.iter().map(|sight| sight.blurred(moved)).collect();
        CameraPairs::of_sights(&capture.cameras, &blurred)
    } else {
        CameraPairs::new(&capture.cameras)
    };
    if noise > 0.0 {
        tally.add_reading(better_reading(&pairs, &mut window, job)?);
    }
    let mut residuals = Residuals::new(&pairs, scan.frames);
    let mut pruning = Pruning::new(views, &pairs, window, job);
    pruning.find_all(&mut tally, &mut residuals)?;
    pruning.settle_all()?;
    pruning.pack_all(&mut tally, &mut images)?;
    images.sort();
    Ok((images, RunCounts { report: tally.into_report(), readings: residuals.into_readings() }))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::capture::Capture;
    use crate::capture::{CaptureParts, Frame, FrameSource};
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::{PreparedScan, inspect_frame};
    use crate::samples::SampleImage;
    use crate::settings::{AlignSettings, CaptureSettings, MixedPixels, Settings};

    /// Views of each place where a demo stands.
    const AT_ONE_PLACE: usize = 6;

    /// A demo that stands at several places. Its depth is off by some share of it, at each pixel by another.
    struct Noisy(Demo, f32);

    impl FrameSource for Noisy {
        fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
            let mut loaded = self.0.load(camera % AT_ONE_PLACE, frame)?;
            for (pixel, inverse_depth) in loaded.inverse_depth.as_mut_slice().iter_mut().enumerate() {
                let draw = crate::random::mix((camera * 1_000_003 + pixel) as u64) >> 40;
                *inverse_depth *= 1.0 + self.1 * (draw as f32 / (1 << 23) as f32 - 1.0);
            }
            Ok(loaded)
        }

        fn place(&self, camera: usize, frame: usize) -> String {
            self.0.place(camera % AT_ONE_PLACE, frame)
        }
    }

    fn capture(scene: &str, noise: f32) -> Capture {
        let demo = Demo::new(&DemoSpec::new(scene).cameras(AT_ONE_PLACE).frames(1).size((80, 60))).unwrap();
        let capture = demo.capture(&CaptureSettings::default());
        // The first two places are near enough for some views of one to look at the other.
        let places =
            [0.0, 12.0, 1000.0].map(|meters| glam::DAffine3::from_translation(glam::DVec3::X * meters));
        let at = |place: &glam::DAffine3, camera: &crate::capture::Camera| crate::capture::Camera {
            world_from_camera: *place * camera.world_from_camera,
            ..camera.clone()
        };
        let cameras =
            places.iter().flat_map(|place| capture.cameras.iter().map(move |camera| at(place, camera)));
        let cameras = cameras.collect();
        let parts = CaptureParts { cameras, source: Arc::new(Noisy(demo, noise)), ..(*capture).clone() };
        Capture::new(parts, 1 << 20)
    }

    #[test]
    fn views_are_pruned_alike_however_few_are_held_at_a_time_and_as_all_at_once() {
        let job = Job::new();
        let mut settings = Settings { align: AlignSettings::OFF, ..Settings::default() };
        for (scene, noise, mixed) in [
            ("orrery", 0.0, MixedPixels::Drop),
            ("nine-cameras", 0.0, MixedPixels::Yield),
            ("nine-cameras", 0.03, MixedPixels::Yield),
        ] {
            settings.pruning.mixed_pixels = mixed;
            let capture = capture(scene, noise);
            let scan: Arc<PreparedScan> = crate::preprocess::scan(&capture, &settings, &job).unwrap();
            let (layer, count) = (80 * 60 * 43, capture.cameras.len());
            let sights = Views::new(&capture, &scan, &settings).sights(&job).unwrap();
            let others: Vec<usize> =
                CameraPairs::of_sights(&capture.cameras, &sights).others(0).map(|(other, _)| other).collect();
            let of_place =
                |place: usize| others.iter().filter(|other| **other / AT_ONE_PLACE == place).count();
            assert!(
                of_place(1) > 0 && others.len() < count - 1,
                "some views of two places overlap: {others:?}"
            );
            let of_bound = |bound: usize| {
                let views = Views { bound, ..Views::new(&capture, &scan, &settings) };
                let (images, counts) =
                    prune_views(ImageBuffer::new(usize::MAX), views, &vec![Vec::new(); count], &job).unwrap();
                let report = counts.finish(count, images.facts());
                (images.into_images().unwrap(), report)
            };
            let (images, report) = of_bound(usize::MAX);
            assert_eq!(report.is_noisy(), noise > 0.0, "{scene}");
            for layers in [0, 2, 5, 13] {
                let (few, of_few) = of_bound(layers * layer);
                assert!(few == images && of_few == report, "{scene}, {layers} layers");
            }
            let inspection = inspect_frame(&capture, Some(&scan), &settings, 0, &job).unwrap();
            let all_at_once: Vec<&SampleImage> =
                inspection.samples.images.iter().map(|image| &**image).collect();
            assert_eq!(images.iter().map(|image| &**image).collect::<Vec<_>>(), all_at_once, "{scene}");
        }
    }
}
