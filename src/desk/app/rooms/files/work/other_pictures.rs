//! Finds the pictures that another program made of a scene's viewpoints.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::app::model::{Content, OpenScene};
use crate::app::rooms::files::model::PictureFolder;
use overlook_engine::capture::TruthView;
use overlook_engine::capture::transforms::{open_pictures, picture_name};
use overlook_engine::error::{Error, Result};

static NEXT_ID: AtomicU64 = AtomicU64::new(1);

/// The pictures in a folder of viewpoints with true pictures, and of cameras that may be held out.
///
/// # Errors
/// `Invalid` where a store is open, or the folder has a picture of neither; those of reading its `transforms.json`.
pub(crate) fn open(folder: &Path, scene: &OpenScene) -> Result<PictureFolder> {
    let Content::Capture { capture, truth } = &scene.content else {
        return Err(Error::invalid(
            folder.display(),
            "a store has no viewpoints with true pictures to compare with; open the capture it was made from",
        ));
    };
    if !folder.is_dir() {
        return Err(Error::io(folder, std::io::ErrorKind::NotFound.into()));
    }
    let with_truth: Vec<TruthView> = truth.iter().filter(|view| view.truth.is_some()).cloned().collect();
    let of_camera = |camera| {
        let view =
            move |number: &i64| TruthView::new(picture_name(camera, *number), camera.clone(), *number, None);
        capture.frame_numbers.iter().map(view)
    };
    let of_cameras: Vec<TruthView> = capture.cameras.iter().flat_map(of_camera).collect();
    let find = |views: &[TruthView]| open_pictures(folder, views, capture.frames_are_ranked());
    let found = if with_truth.is_empty() { None } else { Some(find(&with_truth)) };
    let (of_views, trouble) = match found {
        Some(Ok(pictures)) => (Some(Arc::new(pictures)), None),
        Some(Err(error)) => (None, Some(error)),
        None => (None, None),
    };
    let of_cameras = match find(&of_cameras) {
        Ok(pictures) => Some(Arc::new(pictures)),
        Err(error) if of_views.is_none() => return Err(trouble.unwrap_or(error)),
        Err(_) => None,
    };
    let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
    Ok(PictureFolder { id, of_views, of_cameras, frame_count: capture.frame_count() })
}
