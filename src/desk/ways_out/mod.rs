//! Ways out: the kinds of files that are made of samples and views, with what the dialog, the palette, the field for a path and the
//! command line say of them.

pub(crate) mod cameras;
pub(crate) mod figure;
pub(crate) mod figure_options;
pub(crate) mod film;
pub(crate) mod page;
pub(crate) mod pictures;
pub(crate) mod points;
pub(crate) mod shared;
pub(crate) mod splats;
pub(crate) mod store;

pub(crate) use figure_options::length;
pub(crate) use shared::{
    Action, Facts, FileKind, Frames, Needs, Options, PictureFacts, Scope, Shared, Size, Way, WayOut,
    temporary_folder,
};

/// Every way in the order of the dialog.
pub(crate) const WAYS: [(Way, &WayOut); 8] = [
    (Way::Page, &page::WAY),
    (Way::Splats, &splats::WAY),
    (Way::Film, &film::WAY),
    (Way::Pictures, &pictures::WAY),
    (Way::Figure, &figure::WAY),
    (Way::Points, &points::WAY),
    (Way::Cameras, &cameras::WAY),
    (Way::Store, &store::WAY),
];

impl Way {
    /// What is said of it.
    pub(crate) fn row(self) -> &'static WayOut {
        WAYS[self as usize].1
    }
}

impl Options {
    /// What is written.
    pub(crate) fn kind(&self) -> &'static FileKind {
        (self.way.row().kind)(self)
    }
}
