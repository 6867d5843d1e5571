//! The views that somebody left by a jump: back to them, and forward again, as a browser does.

use super::command::{KeptViewCommand, ViewCommand};
use super::orbit_camera::OrbitCamera;
use crate::app::model::command::Command;
use crate::app::rooms::path::model::PathCommand;

/// Views that were left.
#[derive(Default)]
pub(crate) struct ViewHistory {
    past: Vec<OrbitCamera>,
    future: Vec<OrbitCamera>,
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
        self.future.clear();
        self.past.push(view);
    }

    /// The view before `now`, or after it.
    pub(crate) fn step(&mut self, back: bool, now: OrbitCamera) -> Option<OrbitCamera> {
        let (from, to) =
            if back { (&mut self.past, &mut self.future) } else { (&mut self.future, &mut self.past) };
        let view = from.pop()?;
        to.push(now);
        Some(view)
    }
}
