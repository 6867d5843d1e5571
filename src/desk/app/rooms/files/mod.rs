//! Files: what is opened, saved and remembered, and the paths that a person chooses for that.

mod control;
pub(crate) mod paths;
pub(crate) mod remembered;
mod session;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use crate::app::model::look::{Display, ShownCameras};
use crate::app::model::scene::OpenScene;
use crate::app::model::state::State;
use crate::app::rooms::compare::state::{CompareChoice, CompareLook, CompareSide, CompareVantage};
use crate::app::rooms::files::state::{SessionComparison, SessionLook};

impl SessionLook {
    /// How both views look at a scene.
    pub(crate) fn of(state: &State, scene: &OpenScene) -> Self {
        let name = |camera: usize| scene.cameras.get(camera).map(|camera| camera.name.clone());
        let number = |frame: usize| scene.frame_numbers.get(frame).copied();
        let (live, timeline, look) = (&state.live, &state.timeline, &state.inspector.compare);
        let CompareChoice { sides, from, measure, range } = look.choice;
        // Pictures of other programs are opened anew.
        let has_pictures = sides.iter().any(|side| matches!(side, CompareSide::Pictures(_)));
        let sides = if has_pictures { CompareLook::default().choice.sides } else { sides };
        Self {
            overlay: state.source.overlay,
            color_by: live.color_by,
            holes: live.holes,
            frames_per_second: timeline.frames_per_second,
            source_camera: name(state.source.camera),
            hidden_cameras: live.cameras.off.iter().filter_map(|camera| name(*camera)).collect(),
            solo_camera: live.cameras.solo.and_then(name),
            marked_frames: timeline.markers.iter().filter_map(|frame| number(*frame)).collect(),
            played_frames: timeline.range.and_then(|[first, last]| Some([number(first)?, number(last)?])),
            display: state.display,
            compare: SessionComparison { sides, measure, mode: look.mode, range, from },
        }
    }

    /// Whether all numbers can be shown.
    pub(crate) fn is_finite(&self) -> bool {
        let Display { exposure, offset, gamma, values, .. } = self.display;
        let ends = [values.range, values.isolated].into_iter().flatten().flatten();
        let others = [exposure, offset, gamma, self.frames_per_second];
        others.into_iter().chain(ends).chain(self.compare.range).all(f32::is_finite) && gamma > 0.0
    }

    /// Lets both views look so at a scene.
    pub(crate) fn put(&self, state: &mut State, scene: &OpenScene) {
        let camera = |name: &String| scene.cameras.iter().position(|camera| camera.name == *name);
        let frame = |number: &i64| scene.frame_numbers.iter().position(|known| known == number);
        state.source.overlay = self.overlay;
        if let Some(camera) = self.source_camera.as_ref().and_then(camera) {
            state.source.camera = camera;
        }
        (state.live.color_by, state.live.holes, state.display) = (self.color_by, self.holes, self.display);
        state.live.cameras = ShownCameras {
            off: self.hidden_cameras.iter().filter_map(camera).collect(),
            solo: self.solo_camera.as_ref().and_then(camera),
        };
        let timeline = &mut state.timeline;
        timeline.frames_per_second = self.frames_per_second.clamp(1.0, 120.0);
        timeline.markers = self.marked_frames.iter().filter_map(frame).collect();
        timeline.range = self.played_frames.and_then(|[first, last]| Some([frame(&first)?, frame(&last)?]));
        let SessionComparison { sides, measure, mode, range, from } = self.compare;
        let is_there = !matches!(from, CompareVantage::HoldOut(camera) if camera >= scene.cameras.len());
        let from = if is_there { from } else { CompareVantage::Live };
        let choice = CompareChoice { sides, from, measure, range };
        state.inspector.compare = CompareLook { choice, mode, ..CompareLook::default() };
    }
}
