//! Image databases after the Cinema specification D that hold depth, and say where their pictures were taken from.
//!
//! Source and columns: see [`crate::capture::cinema`].

use std::collections::{BTreeMap, BTreeSet};

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::views::{entry, lens, rig_or_recording};
use crate::capture::cinema::{DATA, DEPTH_FILE, DatabaseCamera, PICTURE_FILE, Table};
use crate::capture::transforms::{Keys, ORTHOGRAPHIC, PictureEntry};
use crate::error::{Error, Result};

/// Cinema.
pub(super) const CINEMA: Reader = Reader {
    source: "Cinema database",
    marks: "data.csv with columns FILE and FILE_depth (Cinema)",
    stands_for_folder: |file| file == DATA,
    is_here: |place| {
        place.has(DATA) && Table::read(&place.join(DATA)).is_ok_and(|table| table.has(PICTURE_FILE))
    },
    poses: "position, focal point and up of every row, or phi and theta about up",
    depth: "planar z in the unit of positions",
    lens: "view_angle of every row, from the upper edge to the lower one, or parallel_scale, half of it in world units, where parallel_projection is 1",
    read,
};

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let path = place.join(DATA);
    let table = Table::read(&path)?;
    if !table.has(DEPTH_FILE) {
        let what = "its pictures have no depth; give a column FILE_depth with files of planar depth (EXR, NumPy or TIFF)";
        return Err(Error::invalid(path.display(), what));
    }
    let cameras = table.cameras()?;
    let mut frames = Vec::new();
    let mut names = Names::default();
    for line in &table.odd_lines {
        description.skip(
            "whose row has more or fewer fields than there are columns",
            format!("{DATA}, line {line}"),
        );
    }
    let mut taken = BTreeSet::new();
    for (row, camera) in table.rows.iter().zip(cameras) {
        let picture = table.text(row, PICTURE_FILE).unwrap_or_default();
        let depth = table.text(row, DEPTH_FILE).filter(|depth| place.join(depth).is_file());
        let (Some(depth), true) = (depth, place.join(picture).is_file()) else {
            description.skip("without a picture or depth", picture);
            continue;
        };
        let Some((camera, pose)) = camera.and_then(|camera| Some((camera, camera.world_from_camera()?)))
        else {
            description.skip("whose camera cannot be read", picture);
            continue;
        };
        let size = image::image_dimensions(place.join(picture)).ok();
        let focal = size.and_then(|(_, rows)| camera.focal_length_px(f64::from(rows)));
        let (Some((columns, rows)), Some(focal)) = (size, focal) else {
            description.skip("without a size, or an angle of view or parallel_scale", picture);
            continue;
        };
        let [columns, rows] = [columns, rows].map(f64::from);
        let (name, time) = (names.of(&camera), table.number(row, "time").unwrap_or(0.0));
        if !taken.insert((name.clone(), time.to_bits())) {
            description.skip("of a place and a time that another row has", picture);
            continue;
        }
        let keys = Keys {
            camera: Some(name),
            frame: Some(time),
            camera_model: camera.parallel_scale.map(|_| ORTHOGRAPHIC.to_owned()),
            ..lens(focal, focal, 0.5 * columns, 0.5 * rows, 0.5)
        };
        frames.push(PictureEntry { keys, ..entry(picture.to_owned(), Some(depth.to_owned()), &pose) });
    }
    let up = table.rows.first().and_then(|row| {
        let [x, y, z] = ["up_x", "up_y", "up_z"].map(|name| table.number(row, name));
        Some([x?, y?, z?])
    });
    let keys = Keys {
        depth_unit_scale_factor: Some(1.0),
        depth_kind: Some("planar_z".to_owned()),
        up: Some(up.unwrap_or([0.0, 0.0, 1.0])),
        ..Keys::default()
    };
    rig_or_recording(place, keys, frames, description, vec![path])
}

/// Names for places, in the order in which they are first met.
#[derive(Default)]
struct Names(BTreeMap<[u64; 6], usize>);

impl Names {
    fn of(&mut self, camera: &DatabaseCamera) -> String {
        let [position, focal_point] =
            [camera.position, camera.focal_point].map(|point| point.to_array().map(f64::to_bits));
        let key = std::array::from_fn(|nth| if nth < 3 { position[nth] } else { focal_point[nth - 3] });
        let next = self.0.len();
        format!("view {}", self.0.entry(key).or_insert(next))
    }
}
