//! A video along the camera path.

use super::shared::{FileKind, Needs, Options, Scope, Size, WayOut};
use crate::text::significant;
use overlook_engine::plural::counted;

pub(crate) const WAY: WayOut = WayOut {
    name: "Video",
    used: "A video along the camera path, which everybody can play.",
    button: "Make the video…",
    command: "video",
    about: "A video along a camera path, as MP4 or GIF",
    kind: |_| &VIDEO,
    size,
    write: None,
};

/// A film of the camera path.
pub(crate) const VIDEO: FileKind =
    FileKind { needs: Needs::Film, ..FileKind::of_samples("Share a video", &["mp4", "m4v", "gif"], "video") };

/// Bytes of a video for each byte of its pictures as PNG, measured with x264 at a quality like that of ours, on videos from one camera to
/// the next (0.06 to 0.1).
const FILM_BY_PNG: f64 = 0.075;

fn size(scope: &Scope, _: &Options) -> Size {
    let Some(picture) = scope.facts.picture else { return Size::missing("once the view rests") };
    let [width, height] = scope.film_size;
    let each = picture.png_bytes * picture.share_of(scope.film_size) * FILM_BY_PNG;
    match scope.film_pictures {
        0 => Size::each(each * scope.frames_per_second, "second", scope.film_size),
        pictures => {
            let seconds = significant(pictures as f64 / scope.frames_per_second);
            let reason = format!("{} of {width}×{height}, {seconds} s", counted(pictures, "picture"));
            Size::about(each * pictures as f64, reason)
        }
    }
}
