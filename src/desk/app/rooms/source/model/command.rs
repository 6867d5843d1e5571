//! What concerns the source view.

use super::look::SourceLook;

/// What concerns the source view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SourceCommand {
    /// Show another camera on the left.
    Camera(usize),
    /// Let the view look otherwise, but for its camera.
    Look(SourceLook),
    /// Show one camera alone in its color where colors are those of cameras, or all of them.
    Isolate(Option<usize>),
}
