//! What a store says of a pixel without its capture: why its sample was kept or dropped, and which camera stands for it.

use glam::DVec2;

use crate::error::Result;
use crate::job::Job;
use crate::preprocess::inspect::{ChainLink, PixelExplanation};
use crate::preprocess::pruning::{Rule, Verdict};
use crate::preprocess::temporal::PixelClass;
use crate::samples::{PixelVerdict, Span, VoteCounts};
use crate::store::file::Store;
use crate::store::playback::Playback;

/// The verdict on a pixel of a camera at a frame, and the span of the sample that it is about; [`Rule::NoSample`] and the frame alone where
/// the pixel has no depth. The witness is known by its camera alone.
///
/// # Errors
/// As [`Store::verdict_at`].
pub fn verdict_in_store(
    store: &Store,
    frame: usize,
    camera: usize,
    at: (usize, usize),
) -> Result<(Span, Verdict)> {
    let alone = Span { start: frame as u32, end: frame as u32 + 1 };
    let (span, stored) = store.verdict_at(frame, camera, at)?.unwrap_or((alone, PixelVerdict::NONE));
    Ok((span, Verdict::of_store(stored).unwrap_or(Verdict::without_witness(Rule::NoSample))))
}

/// Why a pixel was kept or dropped, as far as a store says it: the verdict, the camera of its witness, and the point of a kept sample. What
/// each camera shows of the point needs the source pictures. `None` where the store says nothing of verdicts, and outside the pictures.
/// Only the blocks around the pixel are decoded.
///
/// # Errors
/// As [`Store::verdict_at`] and [`Playback::sample_at`].
pub fn explain_stored_pixel(
    playback: &Playback,
    frame: usize,
    camera: usize,
    (x, y): (usize, usize),
    job: &Job,
) -> Result<Option<PixelExplanation>> {
    let store = playback.store();
    let Some(of_camera) = store.info().cameras.get(camera).filter(|_| store.has_verdicts()) else {
        return Ok(None);
    };
    let (width, height) = of_camera.intrinsics.size();
    if x >= width || y >= height {
        return Ok(None);
    }
    let (span, verdict) = verdict_in_store(store, frame, camera, (x, y))?;
    let sample = playback.sample_at(frame, camera, (x, y), job)?;
    let inverse_depth = sample.as_ref().map_or(0.0, |sample| f64::from(sample.inverse_depth));
    let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
    let witness = (verdict.witness_camera != Verdict::NO_CAMERA).then_some(verdict.witness_camera as usize);
    let own = ChainLink { camera, pixel: (y * width + x) as u32, verdict };
    let kept = Verdict::without_witness(Rule::BestRate);
    let chain = witness.map(|camera| ChainLink { camera, pixel: Verdict::NO_PIXEL, verdict: kept });
    let frames = store.info().frame_numbers.len();
    let class = match span.len() {
        _ if verdict.rule == Rule::NoSample => PixelClass::Invalid,
        length if length == frames => PixelClass::Background,
        1 => PixelClass::Foreground,
        _ => PixelClass::Lasting,
    };
    Ok(Some(PixelExplanation {
        camera,
        x,
        y,
        frame,
        point_in_world: (inverse_depth > 0.0).then(|| of_camera.unproject(center, 1.0 / inverse_depth)),
        class,
        verdict,
        winner: if verdict.is_kept() { Some(camera) } else { witness },
        votes: VoteCounts::default(),
        is_flying: false,
        is_doubtful: sample.is_some_and(|sample| sample.is_doubtful),
        evidence: Vec::new(),
        chain: std::iter::once(own).chain(chain).collect(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Capture;
    use crate::demo::{Demo, DemoSpec};
    use crate::edits::EditList;
    use crate::preprocess::{PreparedScan, inspect_frame, preprocess_edited};
    use crate::settings::{CaptureSettings, Settings};
    use crate::store::file::{Extras, write_spooled};
    use std::path::Path;
    use std::sync::Arc;

    fn capture(scene: &str) -> Arc<Capture> {
        let demo = Demo::new(&DemoSpec::new(scene).cameras(4).frames(5).size((150, 100))).unwrap();
        demo.capture(&CaptureSettings::default())
    }

    /// Settings by which verdicts are stored whatever they take.
    fn all_verdicts() -> Settings {
        let mut settings = Settings::default();
        settings.store.verdicts = 4.0;
        settings
    }

    /// Writes a capture's store, by so many threads.
    fn written(capture: &Capture, settings: &Settings, path: &Path, threads: usize) -> Vec<u8> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let job = Job::new();
            let result = preprocess_edited(capture, settings, &EditList::default(), &job).unwrap();
            let extras = Extras { verdicts: result.verdicts, ..Extras::default() };
            write_spooled(path, &result.outline, &result.images, &extras, &job).unwrap();
        });
        std::fs::read(path).unwrap()
    }

    #[test]
    fn a_store_gives_the_verdict_of_every_pixel_as_its_capture_has_it_whatever_the_threads() {
        let folder = tempfile::tempdir().unwrap();
        for scene in ["nine-cameras", "orrery"] {
            let (capture, settings, job) = (capture(scene), all_verdicts(), Job::new());
            let path = folder.path().join("scene.ovl");
            let bytes = written(&capture, &settings, &path, 3);
            assert_eq!(written(&capture, &settings, &folder.path().join("again.ovl"), 1), bytes, "{scene}");
            let scan: Arc<PreparedScan> = crate::preprocess::scan(&capture, &settings, &job).unwrap();
            let playback = Playback::new(Store::open(&path).unwrap(), 1 << 20);
            let mut rules = std::collections::BTreeSet::new();
            for frame in 0..capture.frame_count() {
                let inspection = inspect_frame(&capture, Some(&scan), &settings, frame, &job).unwrap();
                for (camera, inspected) in inspection.cameras.iter().enumerate() {
                    for (x, y) in (0..100).flat_map(|y| (0..150).map(move |x| (x, y))) {
                        // Each pixel in turn decodes its block: a lattice of them, and all of one camera at one frame.
                        if (frame, camera) != (2, 1) && (x % 7, y % 5) != (frame, camera) {
                            continue;
                        }
                        let expected = inspected.verdict[(x, y)];
                        let (span, found) =
                            verdict_in_store(playback.store(), frame, camera, (x, y)).unwrap();
                        let place = format!("{scene}: camera {camera}, {x}, {y}, frame {frame}");
                        assert_eq!(
                            (found.rule, found.witness_camera),
                            (expected.rule, expected.witness_camera),
                            "{place}"
                        );
                        if found.rule != Rule::NoSample {
                            let level = inspected.level[(x, y)];
                            assert_eq!(span, inspection.path[usize::from(level)], "{place}");
                        }
                        let sample = playback.sample_at(frame, camera, (x, y), &job).unwrap();
                        assert_eq!(sample.is_some(), found.is_kept(), "{place}");
                        rules.insert(found.rule);
                    }
                    let mut seen = 0;
                    playback
                        .store()
                        .each_verdict(frame, camera, |at, _, verdict| {
                            assert_eq!(verdict.rule, inspected.verdict[at].rule as u8);
                            seen += 1;
                        })
                        .unwrap();
                    let with_depth = inspected.verdict.as_slice().iter().filter(|v| v.rule != Rule::NoSample);
                    assert_eq!(seen, with_depth.count(), "{scene}: camera {camera}, frame {frame}");
                }
            }
            assert!(rules.len() > 3, "{scene}: only {rules:?}");
        }
    }

    #[test]
    fn verdicts_change_no_sample_are_kept_by_whoever_copies_them_and_go_where_they_are_not_wanted() {
        let folder = tempfile::tempdir().unwrap();
        let (capture, job) = (capture("nine-cameras"), Job::new());
        let [with, without, again] = ["with", "without", "again"].map(|name| folder.path().join(name));
        let settings = all_verdicts();
        let bytes = written(&capture, &settings, &with, 2);
        let mut bare = settings.clone();
        bare.store.verdicts = 0.0;
        written(&capture, &bare, &without, 2);
        let read = |path: &Path| crate::store::read(path, &job).unwrap().0.images;
        assert_eq!(read(&with), read(&without));
        assert!(!Store::open(&without).unwrap().has_verdicts());
        let mut tight = settings.clone();
        tight.store.verdicts = 0.001;
        written(&capture, &tight, &without, 2);
        assert!(!Store::open(&without).unwrap().has_verdicts(), "they take more than that");
        let store = Store::open(&with).unwrap();
        crate::store::write_again(&again, &store, None, &job).unwrap();
        assert_eq!(std::fs::read(&again).unwrap(), bytes);
        crate::store::write_again(&again, &store, Some(&bare.store), &job).unwrap();
        assert!(!Store::open(&again).unwrap().has_verdicts());
    }

    #[test]
    fn damaged_verdicts_are_an_error_and_leave_the_samples_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (capture, job) = (capture("nine-cameras"), Job::new());
        let path = folder.path().join("scene.ovl");
        let bytes = written(&capture, &all_verdicts(), &path, 2);
        let start = bytes.windows(4).position(|four| four == b"VERD").unwrap();
        let length = u32::from_be_bytes(bytes[start + 4..start + 8].try_into().unwrap()) as usize;
        let samples = crate::store::read(&path, &job).unwrap().0.images;
        for nth in 0..150 {
            let mut damaged = bytes.clone();
            let at = start + 8 + length - 1 - nth * (length - 1) / 149;
            damaged[at] ^= 1 << (nth % 8);
            std::fs::write(&path, &damaged).unwrap();
            let store = Store::open(&path).unwrap();
            let asked = (0..4).flat_map(|camera| (0..5).map(move |frame| (camera, frame)));
            let errors: Vec<_> = asked
                .filter_map(|(camera, frame)| store.each_verdict(frame, camera, |..| {}).err())
                .collect();
            assert!(!errors.is_empty(), "byte {at} of {start} + {length}");
            assert!(errors[0].to_string().contains("chunk 'VERD'"), "{}", errors[0]);
            assert_eq!(crate::store::read(&path, &job).unwrap().0.images, samples);
        }
    }
}
