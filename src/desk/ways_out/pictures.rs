//! Pictures of the live view, or along the camera path.

use super::shared::{Action, FileKind, Needs, Options, Scope, Size, WayOut};
use overlook_engine::plural::counted;

pub(crate) const WAY: WayOut = WayOut {
    name: "Pictures",
    used: "This view as it is shown, or every picture of the camera path: PNG, or EXR with linear color and depth.",
    button: "Save pictures…",
    command: "pictures",
    about: "Pictures along a camera path, as EXR and PNG",
    kind: |options| match (options.along_path, options.linear) {
        (false, false) => &PICTURE,
        (false, true) => &LINEAR_PICTURE,
        (true, true) if options.compares.is_none() => &LINEAR_PICTURES,
        (true, _) => &PICTURES,
    },
    size,
    write: None,
};

/// The picture of the live view: PNG as it is shown, or EXR as it was rendered.
pub(crate) const PICTURE: FileKind = FileKind {
    action: Action::Save,
    needs: Needs::Nothing,
    ..FileKind::of_samples("Share the picture of the live view", &["png", "exr"], "picture")
};

/// The same, EXR where nothing else is said.
pub(crate) const LINEAR_PICTURE: FileKind = FileKind { endings: &["exr", "png"], ..PICTURE };

/// The pictures of the camera path.
pub(crate) const PICTURES: FileKind =
    FileKind { needs: Needs::Film, ..FileKind::of_samples("Share pictures in a folder", &[], "pictures") };

/// The same as EXR with depth.
pub(crate) const LINEAR_PICTURES: FileKind = FileKind { title: "Share EXR pictures in a folder", ..PICTURES };

fn size(scope: &Scope, options: &Options) -> Size {
    let Some(picture) = scope.facts.picture else { return Size::missing("once the view rests") };
    let is_path = options.along_path;
    let is_linear = options.linear && !(is_path && options.compares.is_some());
    let whole = if is_linear { picture.exr_bytes } else { picture.png_bytes };
    match (options.picture_size, scope.film_pictures) {
        (None, _) if !is_path => Size::about(whole, "as the live view shows it".to_owned()),
        (Some(size @ [width, height]), _) if !is_path => {
            Size::about(whole * picture.share_of(size), format!("a picture of {width}×{height}"))
        }
        (_, 0) => Size::each(whole * picture.share_of(scope.film_size), "picture", scope.film_size),
        (_, pictures) => {
            let [width, height] = scope.film_size;
            let reason = format!("{} of {width}×{height}", counted(pictures, "picture"));
            Size::about(whole * picture.share_of(scope.film_size) * pictures as f64, reason)
        }
    }
}
