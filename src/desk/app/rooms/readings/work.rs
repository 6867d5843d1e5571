//! Checks how a capture's poses and depth are read, and shows two readings as pictures.

use std::sync::Arc;

use egui::{Color32, ColorImage};

use crate::app::colormap::opaque;
use crate::app::model::{Message, OpenScene, Same, SceneSource, State};
use crate::app::rooms::readings::state::ReadingImages;
use crate::app::work::worker::Wanted;
use overlook_engine::capture::conventions::{self, Finding};
use overlook_engine::color::srgb8_from_linear;
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;

/// Columns of the pictures at most.
const WIDTH: usize = 320;

#[derive(Clone, PartialEq)]
pub(crate) enum ReadingRequest {
    /// Whether another reading fits better.
    Check(Arc<OpenScene>),
    /// Pictures of the reading as it is, and of the one that a finding names.
    Show(Arc<OpenScene>, Same<Finding>),
}

impl Wanted for ReadingRequest {
    /// Once the first frame is shown: whether the capture's files are read as they are meant. A built-in scene is.
    fn wanted(state: &State) -> Option<Self> {
        let scene =
            state.doc.scene.clone().filter(|_| state.doc.inspected.is_some() && state.has_capture())?;
        let readings = &state.doc.readings;
        if !matches!(scene.origin, SceneSource::Path(_)) || readings.trouble.is_some() {
            return None;
        }
        match &readings.finding {
            None => (!scene.is_reread).then_some(Self::Check(scene)),
            Some(finding) => (readings.is_open && readings.shown.is_none())
                .then(|| Self::Show(scene, Same(finding.clone()))),
        }
    }
}

pub(crate) fn answer(request: ReadingRequest) -> Message {
    match request {
        ReadingRequest::Check(scene) => {
            let found = scene.source().and_then(conventions::check).map(Arc::new);
            let finding = found.map_err(|error| format!("The views could not be compared: {error}"));
            Message::ReadingsChecked { scene: scene.id, finding }
        }
        ReadingRequest::Show(scene, finding) => {
            let images = show(&scene, &finding).map_err(|error| error.to_string());
            Message::ReadingsShown { scene: scene.id, images }
        }
    }
}

fn show(scene: &OpenScene, finding: &Finding) -> Result<ReadingImages> {
    let other = finding.alternative().map_or(finding.claimed, |other| other.reading);
    let pictures = conventions::pictures(scene.source()?, [finding.claimed, other], WIDTH)?;
    let [as_read, otherwise] = &pictures.readings;
    Ok(ReadingImages {
        pictures: [
            image(&pictures.recorded, |color| Some(*color)),
            image(&as_read.color, |color| *color),
            image(&otherwise.color, |color| *color),
        ],
        votes: [as_read, otherwise].map(|views| [views.agree, views.contradict]),
        camera: pictures.camera,
    })
}

/// A picture for the screen; transparent in holes.
fn image<T>(colors: &Grid<T>, color: impl Fn(&T) -> Option<[f32; 3]>) -> Arc<ColorImage> {
    let shown =
        |value: &T| color(value).map_or(Color32::TRANSPARENT, |color| opaque(color.map(srgb8_from_linear)));
    Arc::new(ColorImage::new(colors.size().into(), colors.map(shown).into_vec()))
}
