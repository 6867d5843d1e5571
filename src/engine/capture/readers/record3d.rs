//! `Record3D`'s export "EXR + RGB".
//!
//! Source: the files that the app writes. `metadata.json` has the lens `K` of color, column by column, and `poses` of `qx qy qz qw
//! tx ty tz`, camera to world; x right, y up, looking along −z; world y up, meters. `rgb/N.jpg`; `depth/N.exr`, smaller, of one
//! channel `R` of planar z in meters. Files of frames may be missing, `poses` has all: N counts in it. Portrait pictures have their
//! `K` turned already.

use serde::Deserialize;

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::views::{
    ARKIT_POSES, colors_in, entry, from_opengl, json, lens, number_in, pose_of_quaternion, recording, stem,
};
use crate::capture::transforms::Keys;
use crate::error::{Error, Result};
use crate::plural::counted;

const METADATA: &str = "metadata.json";

/// `Record3D`.
pub(super) const RECORD3D: Reader = Reader {
    source: "Record3D",
    marks: "metadata.json beside rgb/ and depth/, or EXR_RGBD/ (Record3D)",
    stands_for_folder: |file| file == METADATA,
    is_here: |place| root(place).is_some(),
    poses: ARKIT_POSES,
    depth: "planar z in meters, EXR of its own size; 0 is no depth",
    lens: "",
    read,
};

#[derive(Deserialize)]
struct Record3dMetadata {
    /// Column by column.
    #[serde(rename = "K")]
    lens: Vec<f64>,
    poses: Vec<[f64; 7]>,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let root = root(place).unwrap_or_default();
    let path = place.join(&format!("{root}{METADATA}"));
    let metadata: Record3dMetadata = json(&path)?;
    let [fx, _, _, _, fy, _, cx, cy, _] = metadata.lens[..] else {
        let what = format!("K has {} where a lens has 9", counted(metadata.lens.len(), "number"));
        return Err(Error::invalid(path.display(), what));
    };
    if metadata.poses.len() > 1 && metadata.poses.iter().all(|pose| *pose == metadata.poses[0]) {
        let what = "all poses are the same: the front camera's recordings have none; record with the LiDAR camera, or estimate poses with COLMAP";
        return Err(Error::unsupported(path.display(), what));
    }
    description.lens = format!("K of {METADATA}: {fx} {fy} {cx} {cy}");
    let mut frames = Vec::new();
    for name in colors_in(&place.join(&format!("{root}rgb"))) {
        let depth = format!("{root}depth/{}.exr", stem(&name));
        if !place.join(&depth).is_file() {
            description.skip("without depth", name);
            continue;
        }
        let index = number_in(&name).and_then(|number| usize::try_from(number).ok());
        let Some([qx, qy, qz, qw, x, y, z]) = index.and_then(|index| metadata.poses.get(index)) else {
            description.skip("without a pose", name);
            continue;
        };
        match pose_of_quaternion([*qx, *qy, *qz, *qw], [*x, *y, *z]) {
            Some(pose) => {
                let pose = from_opengl(&pose);
                frames.push(entry(format!("{root}rgb/{name}"), Some(depth), &pose));
            }
            None => description.skip("taken while tracking was lost", name),
        }
    }
    let keys = Keys {
        depth_channel: Some("R".to_owned()),
        depth_kind: Some("planar_z".to_owned()),
        depth_invalid_value: Some(0.0),
        noise_free: Some(false),
        up: Some([0.0, 1.0, 0.0]),
        ..lens(fx, fy, cx, cy, 0.5)
    };
    recording(place, keys, frames, description, vec![path])
}

/// The folder of `metadata.json` below the place: it, or the one that the app names.
fn root(place: &SourceFolder) -> Option<String> {
    let roots = ["", "EXR_RGBD/"];
    let is_root = |root: &&&str| {
        place.join(&format!("{root}{METADATA}")).is_file()
            && ["rgb", "depth"].iter().all(|name| place.join(&format!("{root}{name}")).is_dir())
    };
    roots.iter().find(is_root).map(|root| (*root).to_owned())
}
