//! Views that somebody keeps to come back to: where from and when, and a name; and small pictures of views.

use egui::TextureHandle;

use crate::address::ViewAddress;

/// A view that is kept.
pub(crate) struct KeptView {
    pub name: String,
    pub view: ViewAddress,
}

/// What views showed, small: of kept views, and of the keys of the camera path. A view has a picture once it was painted.
#[derive(Default)]
pub(crate) struct ViewPictures(Vec<(ViewAddress, TextureHandle)>);

impl ViewPictures {
    /// The picture of a view.
    pub(crate) fn of(&self, view: &ViewAddress) -> Option<&TextureHandle> {
        self.0.iter().find(|(known, _)| known == view).map(|(_, picture)| picture)
    }

    /// Takes the picture of a view; of views that are not `wanted` none stays.
    pub(crate) fn keep(&mut self, view: ViewAddress, picture: TextureHandle, wanted: &[ViewAddress]) {
        self.0.retain(|(known, _)| *known != view && wanted.contains(known));
        self.0.push((view, picture));
    }
}

/// The name of the next view: its number, the first that none has.
pub(crate) fn next_name(kept: &[KeptView]) -> String {
    let mut names = (1..).map(|number| format!("View {number}"));
    names.find(|name| kept.iter().all(|known| known.name != *name)).unwrap_or_default()
}
