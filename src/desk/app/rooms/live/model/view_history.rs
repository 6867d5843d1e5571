//! The views that somebody left by a jump: back to them, and forward again, as a browser does.

use super::command::{KeptViewCommand, ViewCommand};
use super::orbit_camera::OrbitCamera;
use crate::app::model::command::Command;
use crate::app::rooms::path::model::PathCommand;
use crate::app::rooms::settings::model::undo::Steps;

/// Views that were left.
#[derive(Default)]
pub(crate) struct ViewHistory {
    steps: Steps<OrbitCamera>,
}

impl ViewHistory {
    /// Whether a command takes the view elsewhere at once. Views that are moved by hand stay under the hand.
    pub(crate) fn is_jump(command: &Command) -> bool {
        match command {
            Command::Path(PathCommand::GoToKey(_)) => true,
            Command::View(command) => matches!(
                command,
                ViewCommand::JumpTo(_)
                    | ViewCommand::Home
                    | ViewCommand::FramePoint
                    | ViewCommand::Focus(_)
                    | ViewCommand::LookAlong(_)
                    | ViewCommand::GoToAddress(_)
                    | ViewCommand::Kept(KeptViewCommand::GoTo(_))
                    | ViewCommand::Pasted(_)
            ),
            _ => false,
        }
    }

    /// Notes a view that was left.
    pub(crate) fn left(&mut self, view: OrbitCamera) {
        self.steps.record(view, true);
    }

    /// The view before `now`, or after it.
    pub(crate) fn step(&mut self, back: bool, now: OrbitCamera) -> Option<OrbitCamera> {
        self.steps.step(back, now)
    }
}
