//! The votes of other cameras on kept samples, for edits.
//!
//! What differs from the votes while pruning: each camera is asked what it saw at the first frame of a sample's span, whether or not it
//! sees the same later, and tolerances are the default ones: a list selects the same whatever the samples were pruned with.

use rayon::prelude::*;

use super::agreement::VoteTest;
use super::layers::{CameraLayer, LayerBuilder};
use super::pruning::{SpanSource, measure_others_noise};
use super::temporal::ROOT;
use crate::capture::overlap::OverlapGraph;
use crate::capture::{Camera, Capture};
use crate::error::Result;
use crate::job::Job;
use crate::samples::{ImageBuffer, Sample, SampleVotes, Span, VoteCounts};
use crate::settings::Settings;

/// Asks the frames of a capture about the samples of images. Cameras are those that the samples are of; a camera is recognized by its
/// name. One that the capture does not have says nothing, and nothing is said of its samples.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), `Io` as [`ImageBuffer::get`], and `Cancelled`.
pub fn votes_on(
    images: &ImageBuffer,
    cameras: &[Camera],
    capture: &Capture,
    job: &Job,
) -> Result<SampleVotes> {
    let named = |name: &str| cameras.iter().find(|camera| camera.name == name);
    let capture = capture
        .with_cameras(|_, camera| named(&camera.name).is_some())
        .with_changed_cameras(|_, camera| *camera = named(&camera.name).unwrap_or(camera).clone());
    let pairs = OverlapGraph::complete(&capture.cameras);
    let test = VoteTest::new(&Settings::default(), ROOT);
    let mut order: Vec<usize> = (0..images.len()).collect();
    let start = |index: &usize| images.facts_of(*index).span.start;
    order.sort_by_key(start);
    job.start("Asking other cameras", order.len());
    let mut votes = SampleVotes { images: vec![Vec::new(); order.len()] };
    for of_frame in order.chunk_by(|a, b| start(a) == start(b)) {
        let frame = start(&of_frame[0]);
        if frame as usize >= capture.frame_count() {
            continue;
        }
        let layers = layers_at(&capture, frame, job)?;
        let asked = of_frame.par_iter().map(|&index| {
            job.check()?;
            job.advance(1);
            let image = images.get(index)?;
            let name = &cameras[image.camera as usize].name;
            let Some(camera) = capture.cameras.iter().position(|camera| camera.name == *name) else {
                return Ok((index, Vec::new()));
            };
            let layer = &layers[camera];
            let counts = |sample: Sample| {
                let pixel = sample.y * layer.width + sample.x;
                match layer.inverse_depth[pixel] {
                    0.0 => VoteCounts::OF_SKY,
                    depth if depth > 0.0 => test.counts(&pairs, &layers, camera, pixel as u32),
                    _ => VoteCounts::default(),
                }
            };
            Ok((index, image.samples().map(counts).collect()))
        });
        for (index, asked) in asked.collect::<Result<Vec<_>>>()? {
            votes.images[index] = asked;
        }
    }
    Ok(votes)
}

/// What each camera saw at a frame, as if it saw it at all frames.
fn layers_at(capture: &Capture, frame: u32, job: &Job) -> Result<Vec<CameraLayer>> {
    let settings = Settings::default();
    let builder = LayerBuilder::new(&settings, &capture.cameras, capture.antialiased_color);
    let source = SpanSource { capture, scan: None, builder: &builder };
    let of_camera = |(index, camera): (usize, &Camera)| {
        job.check()?;
        let (width, height) = camera.intrinsics.size();
        let mut layer = CameraLayer::empty_for(width, height, capture.value_channels());
        source.put(index, &mut layer, Span { start: frame, end: frame + 1 }, ROOT)?;
        Ok(layer)
    };
    let mut layers = capture.cameras.par_iter().enumerate().map(of_camera).collect::<Result<Vec<_>>>()?;
    measure_others_noise(&mut layers, capture, &settings, job)?;
    Ok(layers)
}
