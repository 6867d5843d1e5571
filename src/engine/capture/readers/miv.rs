//! MPEG immersive video: a JSON file of cameras beside raw video of texture and depth, as TMIV and RVS read them.
//!
//! Source: TMIV 8 (`SequenceConfig`, `load.cpp`) and RVS 4 (`Parameters`, `image_loading`); see [`crate::capture::miv`] for axes and
//! depth. What differs: cameras have to be perspective, and texture is 4:2:0 or gray.

use serde_json::Value;

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader, SaidBy};
use super::views::{entry, lens};
use crate::capture::miv::{SequenceCamera, SequenceFile, pose, projection};
use crate::capture::transforms::{Keys, Manifest, ManifestOrigin, RawVideoKeys};
use crate::capture::yuv::{PixelFormat, pictures_in};
use crate::error::{Error, Result};
use crate::whole_file;

/// Largest JSON file that is looked into.
const MAX_BYTES: u64 = 16 << 20;

/// MPEG immersive video.
pub(super) const MIV: Reader = Reader {
    source: "MPEG immersive video",
    marks: "a JSON file of \"cameras\" with a \"Projection\" (MPEG immersive video)",
    stands_for_folder: |_| true,
    is_here: |place| sequence_in(place).is_some(),
    poses: "camera to world; yaw, pitch, roll; x forward, y left, z up",
    depth: "inverse depth in levels between near and far, raw video",
    lens: "perspective",
    read,
};

/// Raw video of a camera: the path below the folder, and its format.
struct Video {
    path: String,
    format: PixelFormat,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let name = sequence_in(place).unwrap_or_default();
    let path = place.join(&name);
    let shown = path.display().to_string();
    let bytes = whole_file::read_all(&path)?;
    let sequence: SequenceFile = serde_json::from_slice(&bytes)
        .map_err(|error| Error::invalid(&shown, format!("no sequence of MPEG immersive video ({error})")))?;
    let mut frames = Vec::new();
    let mut inputs = vec![path.clone()];
    for camera in sources(&sequence, &shown)? {
        let keys = keys_of(camera, &shown)?;
        let texture = video(place, &sequence, camera, "texture", &shown)?;
        let depth = video(place, &sequence, camera, "depth", &shown)?;
        let world_from_camera = pose(camera, sequence.world_offset, &shown)?;
        let [columns, rows] = camera.resolution.map(|side| side as usize);
        for picture in pictures(place, &sequence, [&texture, &depth], (columns, rows))? {
            let mut one = entry(texture.path.clone(), Some(depth.path.clone()), &world_from_camera);
            one.keys = Keys {
                camera: Some(camera.name.clone()),
                frame: Some(picture as f64),
                raw_video: RawVideoKeys {
                    picture_in_file: Some(picture),
                    pixel_format: Some(texture.format.name()),
                    depth_pixel_format: Some(depth.format.name()),
                    ..keys.raw_video.clone()
                },
                ..keys.clone()
            };
            frames.push(one);
        }
        inputs.extend([texture.path, depth.path].map(|name| place.join(&name)));
    }
    description.found = frames.len();
    let keys = Keys { up: Some([0.0, 0.0, 1.0]), ..Keys::default() };
    Ok(ReadSource {
        manifest: Manifest { keys, frames, path_easing: None },
        origin: ManifestOrigin { path, folder: place.folder.clone() },
        inputs,
        description,
        said_by: SaidBy::Layout,
    })
}

/// The name of the file that describes the cameras: the one that was named, or the first of the folder's.
fn sequence_in(place: &SourceFolder) -> Option<String> {
    let is_sequence = |name: &str| {
        let path = place.join(name);
        let is_small = path.metadata().is_ok_and(|it| it.is_file() && it.len() <= MAX_BYTES);
        let is_json = name.to_ascii_lowercase().ends_with(".json");
        let document =
            || -> Option<Value> { serde_json::from_slice(&whole_file::read_all(&path).ok()?).ok() };
        is_json && is_small && document().is_some_and(|document| is_of_cameras(&document))
    };
    match &place.file {
        Some(name) => is_sequence(name).then(|| name.clone()),
        None => place.names().find(|name| is_sequence(name)).map(str::to_owned),
    }
}

fn is_of_cameras(document: &Value) -> bool {
    let first = document.get("cameras").and_then(|cameras| cameras.get(0));
    first.is_some_and(|camera| camera.get("Projection").is_some())
}

/// The cameras that took pictures: the listed ones, or else those with names of `v` and a number. The viewport is none.
fn sources<'a>(sequence: &'a SequenceFile, place: &str) -> Result<Vec<&'a SequenceCamera>> {
    let is_numbered = |name: &str| {
        name.strip_prefix('v')
            .is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|it| it.is_ascii_digit()))
    };
    let found: Vec<&SequenceCamera> = match &sequence.source_camera_names {
        Some(names) => {
            let of_name = |name: &String| {
                sequence.cameras.iter().find(|camera| camera.name == *name).ok_or_else(|| {
                    Error::invalid(
                        place,
                        format!("sourceCameraNames has '{name}', which is no camera's Name"),
                    )
                })
            };
            names.iter().map(of_name).collect::<Result<_>>()?
        }
        None => sequence.cameras.iter().filter(|camera| is_numbered(&camera.name)).collect(),
    };
    if found.is_empty() {
        let what = "no camera took pictures; list them as sourceCameraNames, or name them v0, v1 …";
        return Err(Error::invalid(place, what));
    }
    Ok(found)
}

/// Lens and depth of a camera as keys of a manifest.
fn keys_of(camera: &SequenceCamera, place: &str) -> Result<Keys> {
    let lens_of = projection(camera, place)?;
    let (near, far) = camera.near_and_far(place)?;
    Ok(Keys {
        w: Some(f64::from(lens_of.width)),
        h: Some(f64::from(lens_of.height)),
        raw_video: RawVideoKeys {
            depth_range: Some((near, far.is_finite().then_some(far))),
            depth_zero_is_unknown: camera.has_invalid_depth,
            ..RawVideoKeys::default()
        },
        ..lens(lens_of.fx, lens_of.fy, lens_of.cx, lens_of.cy, 0.5)
    })
}

/// The raw video of a camera, in the folder of the content or beside the file of cameras.
fn video(
    place: &SourceFolder,
    sequence: &SequenceFile,
    camera: &SequenceCamera,
    kind: &str,
    shown: &str,
) -> Result<Video> {
    let (bits, space) = if kind == "texture" {
        (camera.bit_depth_color, &camera.color_space)
    } else {
        (camera.bit_depth_depth, &camera.depth_color_space)
    };
    let depth = if bits == 8 { String::new() } else { format!("{bits}le") };
    let names: &[&str] = if space == "YUV400" { &["yuv400p", "gray"] } else { &["yuv420p"] };
    let [width, height] = camera.resolution;
    let file = |start: &str| format!("{}_{kind}_{width}x{height}_{start}{depth}.yuv", camera.name);
    let folders = [format!("{}/", sequence.content_name), String::new()];
    let mut tried = Vec::new();
    for start in names {
        for folder in &folders {
            let path = format!("{folder}{}", file(start));
            if place.join(&path).is_file() {
                let format = PixelFormat::of_key("pixel format", &format!("{start}{depth}"), shown)?;
                return Ok(Video { path, format });
            }
            tried.push(path);
        }
    }
    let what = format!("there is no raw video of camera '{}': {}", camera.name, tried.join(" or "));
    Err(Error::invalid(shown, what))
}

/// The pictures of a camera's two files that belong to the sequence.
fn pictures(
    place: &SourceFolder,
    sequence: &SequenceFile,
    videos: [&Video; 2],
    size: (usize, usize),
) -> Result<std::ops::Range<u64>> {
    let (start, most) = match sequence.frame_ranges.first() {
        Some(range) => (range.start_frame, range.max_number_of_frames),
        None => (0, sequence.frames_number.max(1)),
    };
    let mut end = start.saturating_add(most);
    for video in videos {
        let path = place.join(&video.path);
        let held = pictures_in(&path, video.format, size)?;
        if held <= start {
            let what = format!(
                "the file ends at byte {}, before picture {start} of {}×{} {} ends; is it whole, and are Resolution and bit depth right?",
                path.metadata().map_err(|error| Error::io(&path, error))?.len(),
                size.0,
                size.1,
                video.format.name()
            );
            return Err(Error::invalid(path.display(), what));
        }
        end = end.min(held);
    }
    Ok(start..end)
}
