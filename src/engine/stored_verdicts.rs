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
