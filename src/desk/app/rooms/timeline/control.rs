//! Carries out what concerns time.

use crate::app::control::OverlookApp;
use crate::app::rooms::timeline::{ShownRate, TimeCommand, Timeline};

impl OverlookApp {
    pub(crate) fn apply_to_time(&mut self, command: TimeCommand) {
        let frames = self.state.frame_count();
        let timeline = &mut self.state.timeline;
        match command {
            TimeCommand::Frame(frame) => timeline.go_to(frame, frames),
            TimeCommand::Step(by) => {
                timeline.frame = (timeline.frame as i64 + by).rem_euclid(frames.max(1) as i64) as usize;
            }
            TimeCommand::TogglePlay => {
                timeline.playing = frames > 1 && !timeline.playing;
                timeline.elapsed_secs = 0.0;
                timeline.shown = ShownRate::default();
            }
            TimeCommand::Change(changed) => {
                let Timeline { range, markers, ping_pong, frames_per_second, .. } = *changed;
                timeline.backward &= ping_pong && timeline.ping_pong;
                timeline.frames_per_second = frames_per_second.clamp(1.0, 120.0);
                (timeline.range, timeline.markers, timeline.ping_pong) = (range, markers, ping_pong);
            }
        }
    }
}
