//! Facts about the open capture: what is known of a pixel, and of every camera its thumbnail and the memory of its samples.

use std::sync::Arc;

use egui::ColorImage;
use glam::DVec2;

use crate::app::colormap::{dimmed, recorded};
use crate::app::model::window::DockView;
use crate::app::model::{CameraMemory, Content, Same, State};
use crate::app::rooms::pixel::state::{ProbeKey, Probed, Spot};
use crate::app::work::worker::Wanted;
use overlook_engine::capture::ValueChannel;
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::{
    CameraInspection, FrameInspection, explain_pixel, spans_of_pixel,
};
use overlook_engine::render::output::pick;
use overlook_engine::samples::SampleSet;
use overlook_engine::stored_verdicts::explain_stored_pixel;

impl Wanted for ProbeKey {
    fn wanted(state: &State) -> Option<Self> {
        let shown = state.doc.live_shown.as_ref();
        let (scene, spot) = (state.doc.scene.clone()?, state.doc.probe.spot?);
        let is_live = matches!(spot, Spot::Live { .. });
        if is_live && shown.is_some_and(|shown| shown.key.quality.is_some()) {
            // The mark stays at its place in the scene; the picture at rest is asked again.
            return None;
        }
        let live = shown.filter(|_| is_live).map(|shown| (shown.key.clone(), Same(shown.picture.clone())));
        let inspection = state.inspection_here().cloned().map(Same);
        let (frame, whole) = (state.timeline.frame, state.current_whole().cloned().map(Same));
        Some(Self { scene, spot, frame, inspection, whole, live })
    }

    fn is_of_use(&self, state: &State) -> bool {
        state.doc.probe.spot.is_some()
    }
}

/// The cameras of a frame, each as a small picture.
#[derive(Clone, PartialEq)]
pub(crate) struct ThumbnailRequest {
    pub scene: u64,
    pub inspection: Same<FrameInspection>,
}

impl Wanted for ThumbnailRequest {
    fn wanted(state: &State) -> Option<Self> {
        // *Go to…* shows them as well. In motion they would be made anew for every frame, for nobody to look at.
        let rests = !state.timeline.playing && state.doc.changed_at.is_none();
        let is_seen = state.shows(DockView::Cameras) || (state.shows(DockView::Live) && rests);
        let inspection = state.inspection_here().filter(|_| is_seen)?.clone();
        Some(Self { scene: state.doc.scene.as_ref()?.id, inspection: Same(inspection) })
    }
}

/// The samples whose memory is counted by camera.
#[derive(Clone, PartialEq)]
pub(crate) struct MemoryRequest {
    pub scene: u64,
    pub samples: Same<SampleSet>,
}

impl Wanted for MemoryRequest {
    fn wanted(state: &State) -> Option<Self> {
        // A store plays from disk: its sample set is an outline.
        let is_seen = state.shows(DockView::Report) && state.has_capture();
        let samples = state.whole_samples().filter(|_| is_seen)?.clone();
        Some(Self { scene: state.doc.scene.as_ref()?.id, samples: Same(samples) })
    }
}

/// Largest side of a thumbnail, pixels: of many, smaller ones, as all are sent to the screen at once.
fn side(cameras: usize) -> usize {
    match cameras {
        0..=6 => 512,
        7..=16 => 256,
        17..=64 => 128,
        _ => 64,
    }
}

/// How bright pruned pixels are.
const DIMMED: f32 = 0.45;

/// One picture per camera, in the capture's order.
pub(crate) fn thumbnails(inspection: &FrameInspection) -> Vec<Arc<ColorImage>> {
    let side = side(inspection.cameras.len());
    inspection.cameras.iter().map(|camera| Arc::new(thumbnail(camera, side))).collect()
}

fn thumbnail(camera: &CameraInspection, side: usize) -> ColorImage {
    let (width, height) = camera.verdict.size();
    let step = width.max(height).div_ceil(side).max(1);
    let size = [width.div_ceil(step), height.div_ceil(step)];
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for y in (0..height).step_by(step) {
        for x in (0..width).step_by(step) {
            let own = recorded(camera.frame.color[(x, y)]);
            pixels.push(if camera.verdict[(x, y)].is_kept() { own } else { dimmed(own, DIMMED) });
        }
    }
    ColorImage::new(size, pixels)
}

/// The memory of each camera's samples, in the order of the cameras.
pub(crate) fn memory(samples: &SampleSet) -> Vec<CameraMemory> {
    let mut cameras = vec![CameraMemory::default(); samples.cameras.len()];
    for image in &samples.images {
        let Some(camera) = cameras.get_mut(image.camera as usize) else { continue };
        camera.samples += image.len() as u64;
        let bytes = if image.span.len() > 1 { &mut camera.lasting_bytes } else { &mut camera.frame_bytes };
        *bytes += image.bytes() as u64;
    }
    cameras
}

/// Explains a spot; `None` for a spot without a sample.
pub(crate) fn probe(key: &ProbeKey) -> Option<Probed> {
    let (camera, x, y, seen, mut values) = match key.spot {
        Spot::Source { camera, x, y } => (camera, x, y, None, Vec::new()),
        Spot::Live { x, y, size } => {
            let (live, shown) = key.live.as_ref()?;
            let [x, y] = [(x, size[0], shown.size[0]), (y, size[1], shown.size[1])]
                .map(|(at, of, side)| (2 * at + 1) * side / (2 * of.max(1)));
            let picked = pick(&shown.samples, &live.vantage, shown.rendered()?, x, y)?;
            let shown_values = shown.samples.images[picked.image].values.of(picked.index);
            let values = value_lines(&shown.samples.values, shown_values);
            (picked.camera, picked.x, picked.y, picked.point_in_world, values)
        }
    };
    let explanation = match &key.scene.content {
        Content::Capture { .. } => {
            key.inspection.as_ref().and_then(|inspection| explain_pixel(inspection, camera, x, y))
        }
        Content::Store { playback, .. } => {
            let frame = key.live.as_ref().map_or(key.frame, |(live, _)| live.vantage.frame);
            // What cannot be read of a store is told where its pictures are painted.
            explain_stored_pixel(playback, frame, camera, (x, y), &Job::new()).ok().flatten()
        }
    };
    let mut point_in_world = explanation.as_ref().and_then(|explanation| explanation.point_in_world).or(seen);
    let spans = key.whole.as_ref().map(|samples| spans_of_pixel(samples, camera, x, y));
    if let (Spot::Source { .. }, Some(inspection)) = (key.spot, &key.inspection)
        && let Some(frame) = inspection.cameras.get(camera).map(|camera| &camera.frame)
        && frame.color.get(x, y).is_some()
    {
        values = value_lines(&inspection.samples.values, frame.values.of(y * frame.color.width() + x));
    }
    if let (Spot::Source { .. }, Some(playback)) = (key.spot, key.scene.playback()) {
        // What cannot be read of a store is told where its pictures are painted.
        let stored = playback.sample_at(key.frame, camera, (x, y), &Job::new()).ok().flatten();
        // A dropped pixel has the depth at which the others show it.
        let shown = key.inspection.as_ref().and_then(|inspection| inspection.cameras.get(camera));
        let shown = shown.and_then(|camera| camera.frame.inverse_depth.get(x, y).copied());
        if let Some(inverse_depth) = stored.as_ref().map(|sample| sample.inverse_depth).or(shown) {
            let center = DVec2::new(x as f64, y as f64) + 0.5;
            let is_surface = inverse_depth > 0.0;
            let point = || key.scene.cameras[camera].unproject(center, 1.0 / f64::from(inverse_depth));
            point_in_world = is_surface.then(point);
        }
        if let Some(sample) = stored {
            values = value_lines(&playback.outline().values, &sample.values);
        }
    }
    Some(Probed { spot: key.spot, camera, x, y, point_in_world, explanation, spans, values })
}

/// A line for each channel: the shortest number that has the value's bits, and its unit.
fn value_lines(channels: &[ValueChannel], values: &[f32]) -> Vec<String> {
    let line = |(channel, value): (&ValueChannel, &f32)| match value {
        value if value.is_nan() => format!("{}: no value", channel.name),
        value if channel.unit.is_empty() => format!("{} {value}", channel.name),
        value => format!("{} {value} {}", channel.name, channel.unit),
    };
    channels.iter().zip(values).map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_said_to_its_last_bit_with_its_unit_and_a_missing_one_is_said_to_be_missing() {
        let channel = |name: &str, unit: &str| ValueChannel {
            name: name.to_owned(),
            unit: unit.to_owned(),
            range: [0.0, 1.0],
            tolerance: 0.0,
            is_exact: true,
        };
        let channels = [channel("pressure", "Pa"), channel("grain", ""), channel("speed", "m/s")];
        let value = 0.1_f32 + 0.2_f32;
        let lines = value_lines(&channels, &[value, 7.0, f32::NAN]);
        let said = lines[0].strip_prefix("pressure ").and_then(|line| line.strip_suffix(" Pa")).unwrap();
        assert_eq!(said.parse::<f32>().unwrap().to_bits(), value.to_bits());
        assert_eq!(lines[1..], ["grain 7", "speed: no value"]);
    }
}
