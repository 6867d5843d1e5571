//! The pixel that is looked at: found on a lane, whichever view it was pointed at in.

use std::sync::Arc;

use glam::DVec3;

use super::live_image::{LiveKey, LivePicture};
use crate::app::model::{Content, OpenScene};
use crate::preprocess::inspect::{FrameInspection, PixelExplanation, explain_pixel, spans_of_pixel};
use crate::render::output::pick;
use crate::samples::{SampleSet, Span};

/// Where somebody points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Spot {
    /// A pixel of a camera.
    Source {
        /// Index of the camera.
        camera: usize,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
    },
    /// A pixel of the live picture.
    Live {
        /// Column.
        x: usize,
        /// Row.
        y: usize,
    },
}

/// What the answer depends on.
#[derive(Clone)]
pub(crate) struct ProbeKey {
    /// What is open.
    pub scene: Arc<OpenScene>,
    /// Where.
    pub spot: Spot,
    /// The verdicts at the frame shown; `None` where there are none.
    pub inspection: Option<Arc<FrameInspection>>,
    /// The whole capture's samples, whose spans are told; `None` while there are none.
    pub whole: Option<Arc<SampleSet>>,
    /// The live picture, for a spot in it.
    pub live: Option<(LiveKey, Arc<LivePicture>)>,
}

fn same<T>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (None, None) => true,
        _ => false,
    }
}

impl PartialEq for ProbeKey {
    fn eq(&self, other: &Self) -> bool {
        let picture = |key: &Self| key.live.as_ref().map(|(_, picture)| picture.clone());
        self.scene.id == other.scene.id
            && self.spot == other.spot
            && same(self.inspection.as_ref(), other.inspection.as_ref())
            && same(self.whole.as_ref(), other.whole.as_ref())
            && same(picture(self).as_ref(), picture(other).as_ref())
    }
}

/// What there is to say about a spot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Probed {
    /// Where it was asked for.
    pub spot: Spot,
    /// The camera whose sample it is.
    pub camera: usize,
    /// Column in that camera's picture.
    pub x: usize,
    /// Row in that camera's picture.
    pub y: usize,
    /// The surface point; `None` at infinity and where there is no depth.
    pub point_in_world: Option<DVec3>,
    /// What every camera says; `None` where there are no verdicts.
    pub argument: Option<PixelExplanation>,
    /// The spans in which the pixel is stored; `None` while the whole capture is not pruned, and for stores.
    pub spans: Option<Vec<Span>>,
}

impl ProbeKey {
    /// Whether the live picture can be asked. While it is in motion it may stay out of reach.
    pub(crate) fn has_picture(&self) -> bool {
        self.live.as_ref().is_some_and(|(_, picture)| picture.rendered().is_some())
    }
}

/// Works out what there is to say; `None` where the spot shows nothing.
pub(crate) fn probe(key: &ProbeKey) -> Option<Probed> {
    let (camera, x, y, seen) = match key.spot {
        Spot::Source { camera, x, y } => (camera, x, y, None),
        Spot::Live { x, y } => {
            let (live, shown) = key.live.as_ref()?;
            let picked = pick(&shown.samples, &live.vantage, shown.rendered()?, x, y)?;
            (picked.camera, picked.x, picked.y, picked.point_in_world)
        }
    };
    let argument = key.inspection.as_ref().and_then(|inspection| explain_pixel(inspection, camera, x, y));
    let point_in_world = argument.as_ref().map_or(seen, |argument| argument.point_in_world.or(seen));
    let samples = match &key.scene.content {
        // Of a store played from disk only the frame shown is in memory.
        Content::Store { .. } => None,
        Content::Capture { .. } => key.whole.as_ref(),
    };
    let spans = samples.map(|samples| spans_of_pixel(samples, camera, x, y));
    Some(Probed { spot: key.spot, camera, x, y, point_in_world, argument, spans })
}
