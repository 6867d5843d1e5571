//! Paints the samples that one pruning of a frame has and another lacks, as the live view sees them.

use std::sync::Arc;

use crate::app::camera_cues;
use crate::app::model::window::DockView;
use crate::app::model::{Message, Same, State};
use crate::app::rooms::change::state::ChangeRequest;
use crate::app::work::differing_samples::differing;
use crate::app::work::worker::Wanted;

/// Most columns of the picture: it is drawn over the live view for less than a second.
const COLUMNS: u32 = 640;

impl Wanted for ChangeRequest {
    const IS_SHOWN: bool = false;

    fn wanted(state: &State) -> Option<Self> {
        let pair = state.doc.change.unpainted.clone().filter(|_| state.shows(DockView::Live))?;
        let [width, height] = state.live.size;
        let columns = width.clamp(1, COLUMNS);
        let rows = (u64::from(height) * u64::from(columns) / u64::from(width.max(1))).max(1) as u32;
        let shown = state.doc.live_shown.as_ref();
        let seen = shown.map(|shown| (Same(shown.picture.clone()), shown.key.vantage.camera.clone()));
        let camera = state.live_camera([columns, rows])?;
        Some(Self { scene: state.doc.scene.as_ref()?.id, pair, camera, seen })
    }
}

/// What went and what came; `None` where nothing did that is in view.
pub(crate) fn paint(request: ChangeRequest) -> Message {
    let pair = request.pair.each_ref().map(|inspection| &*inspection.samples);
    let seen = request.seen.as_ref();
    let seen = seen.and_then(|(picture, camera)| Some((&**picture.rendered()?, camera)));
    let pictures = differing(pair, &request.camera, seen, camera_cues::color);
    let pictures = pictures.map(|(picture, count)| (count > 0).then(|| Arc::new(picture)));
    Message::ChangePainted { request: Box::new(request), pictures }
}
