//! The selected pixel, and what is known of it.

use std::sync::Arc;

use egui::{Pos2, pos2};
use glam::DVec3;

use crate::app::model::picture::{LiveKey, LivePicture};
use crate::app::model::same::Same;
use crate::app::model::scene::OpenScene;
use overlook_engine::capture::Camera;
use overlook_engine::preprocess::inspect::{FrameInspection, PixelExplanation};
use overlook_engine::preprocess::registration::Outcome;
use overlook_engine::samples::{SampleSet, Span};

/// The selected pixel.
#[derive(Default)]
pub(crate) struct InspectedPixel {
    /// Where somebody points.
    pub spot: Option<Spot>,
    /// Whether it stays when the pointer goes.
    pub pinned: bool,
    pub shown: Option<Arc<Probed>>,
}

/// Where somebody points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Spot {
    /// A pixel of a camera.
    Source { camera: usize, x: usize, y: usize },
    /// A pixel of a live picture of this size: one of another size shows the same place elsewhere.
    Live { x: usize, y: usize, size: [usize; 2] },
}

/// What the answer depends on.
#[derive(Clone, PartialEq)]
pub(crate) struct ProbeKey {
    pub scene: Arc<OpenScene>,
    pub spot: Spot,
    /// The frame shown.
    pub frame: usize,
    /// The verdicts at the frame shown; `None` for a store, and until they are computed.
    pub inspection: Option<Same<FrameInspection>>,
    /// The whole capture's samples, for the spans of the pixel; `None` while there are none.
    pub whole: Option<Same<SampleSet>>,
    /// The live picture, for a spot in it.
    pub live: Option<(LiveKey, Same<LivePicture>)>,
}

impl ProbeKey {
    /// Whether the pixels of the live picture can be read: in motion they may stay on the GPU.
    pub(crate) fn has_picture(&self) -> bool {
        self.live.as_ref().is_some_and(|(_, picture)| picture.rendered().is_some())
    }
}

/// What is known of a spot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Probed {
    /// Where the person pointed.
    pub spot: Spot,
    /// The camera whose sample it is.
    pub camera: usize,
    pub x: usize,
    pub y: usize,
    /// The surface point; `None` at infinity and without depth.
    pub point_in_world: Option<DVec3>,
    /// The evidence of every camera; `None` without verdicts.
    pub explanation: Option<PixelExplanation>,
    /// The spans in which the pixel is stored; `None` while the whole capture is not pruned, and for stores.
    pub spans: Option<Vec<Span>>,
    /// Scalar values with their names and units, one line a channel; in the live view those of the sample that is shown, else as recorded.
    pub values: Vec<String>,
}

impl Probed {
    /// The pixel that its sample was recorded in: it stays the same surface point when the view turns.
    pub(crate) fn recorded_at(&self) -> Spot {
        Spot::Source { camera: self.camera, x: self.x, y: self.y }
    }

    /// Where a camera shows the point, in its pixels, and whether it sees it.
    pub(crate) fn in_camera(&self, cameras: &[Camera], camera: usize) -> Option<(Pos2, bool)> {
        if camera == self.camera {
            return Some((pos2(self.x as f32 + 0.5, self.y as f32 + 0.5), true));
        }
        if let Some(row) = self.explanation.as_ref().and_then(|explanation| explanation.evidence.get(camera))
        {
            let sees = matches!(row.outcome, Some(Outcome::Same(_)));
            return row.position.map(|position| (pos2(position.x as f32, position.y as f32), sees));
        }
        let (position, _) = cameras.get(camera)?.project(self.point_in_world?)?;
        Some((pos2(position.x as f32, position.y as f32), false))
    }
}
