//! The values of the kept samples at a frame, in order, for their histogram.

use crate::app::model::look::{FrameValues, ShownCameras};
use crate::app::model::picture::ColorBy;
use crate::app::model::window::DockView;
use crate::app::model::{Message, Same, State};
use crate::app::work::shown_samples::CameraFilter;
use crate::app::work::worker::Wanted;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::render::output;
use overlook_engine::samples::SampleSet;
use overlook_engine::store::playback::Playback;

/// What is put in order: the values that the live view shows in colors.
#[derive(Clone, PartialEq)]
pub(crate) struct ValuesRequest {
    scene: u64,
    /// All samples; an outline where a store plays from disk.
    samples: Same<SampleSet>,
    playback: Option<Same<Playback>>,
    frame: usize,
    cameras: ShownCameras,
    channel: usize,
}

impl Wanted for ValuesRequest {
    /// Once the live view rests, while the panel that shows them is open.
    fn wanted(state: &State) -> Option<Self> {
        let shown = state.doc.live_shown.as_ref().filter(|_| state.shows(DockView::Color))?;
        let key = &shown.key;
        if key.color_by != ColorBy::Value || key.quality.is_some() || key.in_motion {
            return None;
        }
        let (channel, _) = state.display.values.channel_of(&key.samples.values)?;
        Some(Self {
            scene: key.scene,
            samples: key.samples.clone(),
            playback: key.playback.clone(),
            frame: key.vantage.frame,
            cameras: key.cameras.clone(),
            channel,
        })
    }
}

/// Puts the values in order.
///
/// # Errors
/// Those of reading a store, and `Cancelled`.
pub(crate) fn values(request: &ValuesRequest, job: &Job) -> Result<Message> {
    let all = match &request.playback {
        None => request.samples.0.clone(),
        Some(playback) => playback.at(request.frame, job)?,
    };
    let shown = CameraFilter::default().of(all, &request.cameras);
    let ascending = output::kept_values(&shown, request.frame, request.channel);
    let values = FrameValues { channel: request.channel, ascending };
    Ok(Message::ValuesCounted { scene: request.scene, values })
}
