//! A camera path: the views of a manifest as keys, and every frame of a store between them.

use std::path::Path;

use overlook_engine::capture::{Camera, TruthView, transforms};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::Vantage;
use overlook_engine::render::film::{PathKey, pose_at};
use overlook_engine::store::file::StoreInfo;

/// A film: where from at which frame, and the frames' numbers.
#[derive(Clone, Debug)]
pub(crate) struct Stops {
    pub(crate) vantages: Vec<Vantage>,
    pub(crate) numbers: Vec<i64>,
}

/// One stop for every frame of the store from the first key to the last, interpolated by [`pose_at`]. Size and focal length are
/// those of the first key, so that all pictures fit into one film. A single key is a still camera for all frames.
pub(crate) fn along(manifest: &Path, store: &StoreInfo) -> Result<Stops> {
    let mut views = transforms::open_views_of(manifest, store.provenance.frames_are_ranked)?;
    views.sort_by_key(|view| view.frame_number);
    let invalid = |what: &str| Err(Error::invalid(manifest.display(), what));
    if let Some(pair) = views.windows(2).find(|pair| pair[0].frame_number == pair[1].frame_number) {
        let time = pair[0].frame_number;
        return invalid(&format!("two views at time {time}; a camera path has one place at a time"));
    }
    let (Some(first), Some(last)) = (views.first(), views.last()) else { return invalid("has no view") };
    let all = views.len() == 1;
    let range = first.frame_number..=last.frame_number;
    let key = |view: &TruthView| PathKey {
        time: view.frame_number as f64,
        world_from_camera: view.camera.world_from_camera,
    };
    let keys: Vec<PathKey> = views.iter().map(key).collect();
    let mut stops = Stops { vantages: Vec::new(), numbers: Vec::new() };
    for (frame, &number) in store.frame_numbers.iter().enumerate() {
        if !all && !range.contains(&number) {
            continue;
        }
        let world_from_camera = pose_at(&keys, number as f64).unwrap_or(first.camera.world_from_camera);
        let camera = Camera { world_from_camera, ..first.camera.clone() };
        stops.vantages.push(Vantage { camera, frame });
        stops.numbers.push(number);
    }
    if stops.numbers.is_empty() { invalid("no view is at a frame of the store") } else { Ok(stops) }
}
