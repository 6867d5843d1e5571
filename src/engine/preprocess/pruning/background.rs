//! The background: every camera's static pixels as a layer, before they are pruned.

use std::sync::Arc;

use rayon::prelude::*;

use crate::capture::Capture;
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::measure_noise_between;
use crate::preprocess::layers::{CameraLayer, LayerBuilder};
use crate::preprocess::temporal::{ROOT, TemporalScan, all_frames};
use crate::settings::{AgreementRule, Settings};

/// A layer with normals, and the pixels of its samples, ascending.
pub(crate) type StaticLayer = (CameraLayer, Vec<u32>);

/// The same with rates and noise between cameras, ready to be pruned.
pub(crate) fn rated(
    capture: &Capture,
    layers: Vec<StaticLayer>,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<CameraLayer>> {
    let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
    let rated = layers.into_par_iter().zip(&capture.cameras).map(|((mut layer, pixels), camera)| {
        job.check()?;
        builder.rate(&mut layer, camera, &pixels);
        Ok(layer)
    });
    let mut rated: Vec<CameraLayer> = rated.collect::<Result<_>>()?;
    measure_others_noise(&mut rated, capture, settings, job)?;
    Ok(rated)
}

/// Notes in each layer how noisy it is beside those of other cameras, where cameras vote.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn measure_others_noise(
    layers: &mut [CameraLayer],
    capture: &Capture,
    settings: &Settings,
    job: &Job,
) -> Result<()> {
    if settings.pruning.agreement != AgreementRule::Off && !capture.is_noise_free() {
        let noise = measure_noise_between(&OverlapGraph::complete(&capture.cameras), layers, job)?;
        layers.iter_mut().zip(noise).for_each(|(layer, noise)| layer.noise_between = noise);
    }
    Ok(())
}

/// Every camera's static pixels with normals, not rated yet: no pruning threshold touches them.
pub(crate) fn static_layers(
    capture: &Capture,
    scan: &TemporalScan,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<StaticLayer>> {
    let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
    let of_camera = |index: usize| {
        job.check()?;
        static_layer(&builder, capture, scan, settings, index)
    };
    (0..scan.cameras.len()).into_par_iter().map(of_camera).collect()
}

/// The same of one camera.
///
/// # Errors
/// `Io` where the temporary file cannot be read.
pub(crate) fn static_layer(
    builder: &LayerBuilder<'_>,
    capture: &Capture,
    scan: &TemporalScan,
    settings: &Settings,
    index: usize,
) -> Result<StaticLayer> {
    let (camera, of_camera) = (&capture.cameras[index], &scan.cameras[index]);
    let (width, height) = camera.intrinsics.size();
    let samples = match (&scan.spans, &of_camera.ranges) {
        (Some(spans), _) => spans.get(index, all_frames(scan.frames))?.unwrap_or_default(),
        (None, Some(ranges)) => {
            let test = scan.static_test(index, &settings.spans);
            Arc::new(ranges.samples(&ranges.static_pixels(&settings.spans, &test)))
        }
        (None, None) => Arc::default(),
    };
    let mut layer = CameraLayer::empty_for(width, height, capture.value_channels());
    layer.noise = of_camera.noise.clone();
    // Those of all frames are their means.
    layer.noise_share = vec![(scan.frames.max(1) as f32).sqrt().recip()];
    layer.depth_step_relative = of_camera.depth_step_relative;
    layer.put(ROOT, &samples);
    builder.estimate_normals(&mut layer, camera, &samples.pixels);
    Ok((layer, samples.pixels.clone()))
}
