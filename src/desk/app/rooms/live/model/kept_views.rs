//! Views that somebody keeps to come back to: where from and when, a name, and a small picture.

use egui::TextureHandle;

use crate::address::ViewAddress;

/// A view that is kept.
pub(crate) struct KeptView {
    pub name: String,
    pub view: ViewAddress,
    /// What it showed; `None` until that is painted.
    pub picture: Option<TextureHandle>,
}

/// The name of the next view: its number, the first that none has.
pub(crate) fn next_name(kept: &[KeptView]) -> String {
    let mut names = (1..).map(|number| format!("View {number}"));
    names.find(|name| kept.iter().all(|known| known.name != *name)).unwrap_or_default()
}
