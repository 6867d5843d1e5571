//! Everything at one frame that no tolerance touches: all samples on all levels with normals, footprints and facets. Whoever
//! turns a threshold prunes these again and again; whatever is decided on one level sees nothing of the deeper ones, so that
//! the verdicts are those of the way down from level to level.

use std::sync::Arc;

use rayon::prelude::*;

use super::background::{Background, remember, remembered};
use super::descent::Descent;
use super::layer::{Layer, Level, NO_SAMPLE, ROOT};
use super::pruning::{self, Decided, Rig};
use super::{PixelClass, Span, TemporalScan};
use crate::capture::Capture;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::settings::{MixedPixels, NormalSettings, PruningMethod, RateModel, Settings, SpanSettings};

/// What the layers of a frame depend on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameKey {
    frame: usize,
    normals: NormalSettings,
    spans: SpanSettings,
    rate: RateModel,
    cosine_floor: f32,
    first_camera: bool,
    mixed_pixels: MixedPixels,
}

/// All cameras at one frame, ready to be pruned.
#[derive(Debug)]
pub struct FrameLayers {
    /// The spans that contain the frame, by level.
    pub path: Vec<Span>,
    /// Every sample at the frame, per camera.
    pub layers: Arc<Vec<Layer>>,
    /// The same for the eye, per camera.
    pub planes: Vec<CameraPlanes>,
}

/// What is shown of a layer beside its verdicts.
#[derive(Clone, Debug)]
pub struct CameraPlanes {
    /// Over how many frames each pixel is the same, in words.
    pub class: Arc<Grid<PixelClass>>,
    /// The level of each pixel's sample.
    pub level: Arc<Grid<Level>>,
    /// World-space normals; zero where there is none.
    pub normal_in_world: Arc<Grid<[f32; 3]>>,
    /// Footprint of each pixel; infinite where there is no sample.
    pub footprint: Arc<Grid<f32>>,
}

impl FrameLayers {
    /// The layers of `frame`; with a `scan`, made once for as long as the settings that touch them and the frame stay.
    ///
    /// # Errors
    /// As [`Descent::enter`].
    pub fn of(
        capture: &Capture,
        scan: Option<&TemporalScan>,
        rig: &Rig<'_>,
        settings: &Settings,
        frame: usize,
        job: &Job,
    ) -> Result<Arc<Self>> {
        let key = FrameKey {
            frame,
            normals: settings.normals.clone(),
            spans: settings.spans.clone(),
            rate: settings.pruning.rate,
            cosine_floor: settings.pruning.cosine_floor,
            first_camera: settings.pruning.method == PruningMethod::FirstCamera,
            mixed_pixels: settings.pruning.mixed_pixels,
        };
        if let Some(layers) = scan.and_then(|scan| remembered(&scan.memo.frame, &key)) {
            return Ok(layers);
        }
        let background = match scan {
            Some(scan) => Background::undecided(scan.rated_layers(capture, settings, job)?),
            None => Background::none(capture),
        };
        let mut descent = Descent::new(capture, scan, rig, settings, background);
        let path = descent.tree().path(frame);
        for (level, &span) in path.iter().enumerate().skip(1) {
            descent.put_span(span, level as Level, job)?;
        }
        let planes = descent.layers.par_iter().map(|layer| planes(layer, path.len())).collect();
        let layers = Arc::new(Self { path, layers: Arc::new(descent.layers), planes });
        if let Some(scan) = scan {
            remember(&scan.memo.frame, key, layers.clone());
        }
        Ok(layers)
    }

    /// Decides every sample. Gives the verdicts per level, per camera.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn prune(&self, rig: &Rig<'_>, settings: &Settings, job: &Job) -> Result<Vec<Vec<Decided>>> {
        let statuses = pruning::no_statuses(&self.layers);
        (0..self.path.len())
            .map(|level| pruning::prune(rig, &self.layers, &statuses, level as Level, settings, job))
            .collect()
    }
}

fn planes(layer: &Layer, levels: usize) -> CameraPlanes {
    let (width, height) = (layer.width, layer.height());
    let class = layer.level.iter().map(|&level| class_of(level, levels)).collect();
    let normals = layer.normal.iter().map(glam::Vec3::to_array).collect();
    CameraPlanes {
        class: Arc::new(Grid::from_vec(width, height, class)),
        level: Arc::new(Grid::from_vec(width, height, layer.level.clone())),
        normal_in_world: Arc::new(Grid::from_vec(width, height, normals)),
        footprint: Arc::new(Grid::from_vec(width, height, layer.footprint.clone())),
    }
}

fn class_of(level: Level, levels: usize) -> PixelClass {
    match level {
        NO_SAMPLE => PixelClass::Invalid,
        ROOT => PixelClass::Background,
        level if usize::from(level) + 1 == levels => PixelClass::Foreground,
        _ => PixelClass::Lasting,
    }
}
