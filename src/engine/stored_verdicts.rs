//! What a store says of pixels without its capture: why their samples were kept or dropped, and which camera stands for them.

use std::sync::{Arc, OnceLock};

use glam::DVec2;
use half::f16;

use crate::capture::{Frame, Values};
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::preprocess::inspect::{CameraInspection, ChainLink, FrameInspection, PixelExplanation};
use crate::preprocess::pruning::{Rule, Verdict};
use crate::preprocess::temporal::{NO_SAMPLE, PixelClass, SpanLevel};
use crate::render::{Picture, Renderer, Vantage};
use crate::samples::{PixelVerdict, SampleSet, Span, VoteCounts};
use crate::settings::{Antialias, Backend, RenderSettings};
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
    let class = match verdict.rule {
        Rule::NoSample => PixelClass::Invalid,
        _ => class_of(span, store.info().frame_numbers.len()),
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

/// For how long a sample holds, in words.
fn class_of(span: Span, frames: usize) -> PixelClass {
    match span.len() {
        length if length == frames => PixelClass::Background,
        1 => PixelClass::Foreground,
        _ => PixelClass::Lasting,
    }
}

/// All cameras of a store at a frame, as [`inspect_frame`](crate::preprocess::inspect_frame) gives those of a capture, as far as a store says
/// it: verdicts, spans and kept samples. Kept pixels have the color and depth of their samples; dropped ones what the kept samples show from
/// their camera; those without a sample have no depth. Normals and values are left out, and so is all that compares source pictures
/// ([`FrameInspection::is_of_store`]). `None` where the store says nothing of verdicts.
///
/// # Errors
/// As [`Store::each_verdict`], [`Playback::at`] and [`Renderer::render`]; `Cancelled`.
pub fn inspect_stored_frame(playback: &Playback, frame: usize, job: &Job) -> Result<Option<FrameInspection>> {
    if !playback.store().has_verdicts() {
        return Ok(None);
    }
    let samples = playback.at(frame, job)?;
    let mut path: Vec<Span> = playback.store().info().images.iter().map(|image| image.span).collect();
    path.retain(|span| span.contains(frame));
    path.sort_by_key(|span| (std::cmp::Reverse(span.len()), *span));
    path.dedup();
    let mut renderer = Renderer::new();
    job.start("Reading what became of the pixels", samples.cameras.len());
    let cameras = (0..samples.cameras.len()).map(|camera| {
        job.check()?;
        let read = stored_camera(playback, &samples, &mut path, &mut renderer, [frame, camera], job);
        job.advance(1);
        read
    });
    let cameras = cameras.collect::<Result<Vec<_>>>()?;
    let settings = samples.settings.clone();
    let agreement = Arc::new((0..cameras.len()).map(|_| OnceLock::new()).collect());
    let layers = Arc::default();
    Ok(Some(FrameInspection { frame, path, cameras, samples, layers, settings, agreement }))
}

/// One camera of [`inspect_stored_frame`]. Spans in which no sample was kept are added to the path.
fn stored_camera(
    playback: &Playback,
    samples: &Arc<SampleSet>,
    path: &mut Vec<Span>,
    renderer: &mut Renderer,
    [frame, camera]: [usize; 2],
    job: &Job,
) -> Result<CameraInspection> {
    let of_camera = &samples.cameras[camera];
    let (width, height) = of_camera.intrinsics.size();
    let frames = samples.frame_count();
    let mut verdict = Grid::filled(width, height, Verdict::without_witness(Rule::NoSample));
    let mut class = Grid::filled(width, height, PixelClass::Invalid);
    let mut level = Grid::filled(width, height, NO_SAMPLE);
    playback.store().each_verdict(frame, camera, |at, span, stored| {
        let Some(found) = Verdict::of_store(stored) else { return };
        let place = path.iter().position(|known| *known == span).unwrap_or_else(|| {
            path.push(span);
            path.len() - 1
        });
        (verdict[at], class[at], level[at]) = (found, class_of(span, frames), place as SpanLevel);
    })?;
    let vantage = Vantage { camera: of_camera.clone(), frame };
    let of_store = &samples.settings.render;
    let settings = RenderSettings { antialias: Antialias::Off, backend: Backend::Cpu, ..of_store.clone() };
    let (shown, _) = renderer.render(samples, &vantage, &settings, job)?;
    let mut frame = frame_of(&shown, &class);
    for image in samples.images.iter().filter(|image| image.camera as usize == camera) {
        for (sample, (color, inverse_depth)) in
            image.samples().zip(image.color.iter().zip(image.inverse_depths()))
        {
            let at = (sample.x, sample.y);
            (frame.color[at], frame.inverse_depth[at]) = (*color, inverse_depth);
        }
    }
    let normal_in_world = Arc::new(Grid::filled(width, height, [0.0; 3]));
    let (class, level) = (Arc::new(class), Arc::new(level));
    Ok(CameraInspection { frame: Arc::new(frame), class, level, verdict, normal_in_world })
}

/// A picture of the kept samples as a frame; without depth where a pixel has no sample, or where the picture shows nothing.
fn frame_of(shown: &Picture, class: &Grid<PixelClass>) -> Frame {
    let (width, height) = class.size();
    let inverse_depth = Grid::from_fn(width, height, |x, y| match class[(x, y)] {
        PixelClass::Invalid => -1.0,
        _ => shown.inverse_depth[(x, y)],
    });
    Frame {
        color: shown.color.map(|color| color.map(f16::from_f32)),
        inverse_depth,
        normal_in_world: None,
        depth_step_relative: 0.0,
        values: Values::default(),
    }
}
