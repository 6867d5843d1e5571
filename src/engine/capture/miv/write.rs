//! Writing a capture as a sequence that TMIV and RVS read.
//!
//! ```text
//! DIR/NAME.json                                       written last; a failure leaves nothing
//! DIR/NAME/v0_texture_640x480_yuv420p10le.yuv …       all frames, one after the other
//! DIR/NAME/v0_depth_640x480_yuv420p16le.yuv …
//! ```

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DQuat, DVec3};
use rayon::prelude::*;
use serde_json::{Value, json};
use tempfile::{NamedTempFile, TempPath};

use super::sequence::{SequenceCamera, SequenceFile, rotation};
use crate::capture::camera::{Camera, in_perspective};
use crate::capture::parts::Capture;
use crate::capture::yuv::{ColorMatrix, LevelOrder, LevelRange, PixelFormat, encode_color, encode_levels};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::whole_file;

const TEXTURE: PixelFormat = PixelFormat { bits: 10, has_chroma: true };
const DEPTH: PixelFormat = PixelFormat { bits: 16, has_chroma: true };

/// What a camera's depth spans over all frames.
#[derive(Clone, Copy)]
struct CameraDepths {
    /// Largest and smallest inverse depth above 0.
    nearest: f32,
    farthest: f32,
    has_sky: bool,
    has_unknown: bool,
}

/// Writes every frame of a capture as the sequence `name` below `folder`. The world is turned so that up is z. Cameras are named
/// `v0`, `v1` … in their order, as TMIV wants it.
///
/// Depth has 16 bits between each camera's nearest and farthest; the far plane is infinite where a camera sees the sky. Progress is
/// counted in frames, twice each.
///
/// # Errors
/// `Io` where something cannot be written, `Unsupported` for orthographic cameras and for pictures of odd width or height, which 4:2:0
/// has not, whatever loading a frame gives, and [`Error::Cancelled`].
pub fn write_sequence(folder: &Path, name: &str, capture: &Capture, job: &Job) -> Result<()> {
    let what =
        "what reads raw video of this kind knows cameras in perspective alone; export points or pictures";
    in_perspective(&capture.cameras, &capture.name, what)?;
    for camera in &capture.cameras {
        let (width, height) = camera.intrinsics.size();
        if width % 2 == 1 || height % 2 == 1 {
            let what = format!(
                "camera '{}' has {width}×{height} pixels; 4:2:0 video needs an even number of columns and rows",
                camera.name
            );
            return Err(Error::unsupported(&capture.name, what));
        }
    }
    job.start("writing raw video", 2 * capture.cameras.len() * capture.frame_count());
    let content = folder.join(name);
    let made = NewFolders::make(&content)?;
    write_into(&content, name, capture, job)?;
    made.keep();
    Ok(())
}

/// Folders that were made for an export, which are removed again if it fails.
struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    fn make(folder: &Path) -> Result<Self> {
        let is_missing = |place: &&Path| !place.as_os_str().is_empty() && !place.exists();
        let missing = folder.ancestors().take_while(is_missing).map(Path::to_path_buf).collect();
        let made = Self(missing);
        std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        Ok(made)
    }

    fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        // The innermost first; one that something else was put into stays.
        for folder in &self.0 {
            let _ = std::fs::remove_dir(folder);
        }
    }
}

/// Writes the video into a folder that is there, and the cameras beside it. Files take their names once all of them are complete.
fn write_into(content: &Path, name: &str, capture: &Capture, job: &Job) -> Result<()> {
    let path = content.with_file_name(format!("{name}.json"));
    let z_from_up = DAffine3::from_quat(DQuat::from_rotation_arc(capture.up_in_world, DVec3::Z));
    let places = capture.cameras.iter().map(|camera| z_from_up.transform_point3(camera.position_in_world()));
    let offset = world_offset(places);
    let written_from_world = DAffine3::from_translation(-offset.unwrap_or_default()) * z_from_up;
    let cameras = (0..capture.cameras.len()).into_par_iter().map(|index| {
        let range = range(extent(capture, index, job)?);
        let camera = &capture.cameras[index];
        let video = write_camera(content, index, capture, &range, job)?;
        Ok((
            entry(camera, &format!("v{index}"), &(written_from_world * camera.world_from_camera), &range),
            video,
        ))
    });
    let (cameras, video): (Vec<SequenceCamera>, Vec<[Unfinished; 2]>) =
        cameras.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    let sequence = SequenceFile {
        version: json!("4.0"),
        content_name: name.to_owned(),
        bounding_box_center: vec![0.0; 3],
        world_offset: offset.map(|offset| offset.to_array()),
        fps: 30.0,
        frames_number: capture.frame_count() as u64,
        lengths_in_meters: Some(true),
        source_camera_names: Some(cameras.iter().map(|camera| camera.name.clone()).collect()),
        frame_ranges: Vec::new(),
        cameras,
    };
    // Video of one capture must never be left beside the cameras of another.
    match std::fs::remove_file(&path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(&path, error)),
        _ => (),
    }
    let text = serde_json::to_vec_pretty(&sequence)
        .map_err(|error| Error::io(&path, std::io::Error::from(error)))?;
    let mut named = NewFiles(Vec::new());
    for Unfinished { file, path } in video.into_iter().flatten() {
        whole_file::persist(file, &path)?;
        named.0.push(path);
    }
    whole_file::write_all(&path, text)?;
    named.0.clear();
    Ok(())
}

/// Files that took their names, and lose them again if what belongs to them cannot be written.
struct NewFiles(Vec<PathBuf>);

impl Drop for NewFiles {
    fn drop(&mut self) {
        for file in &self.0 {
            let _ = std::fs::remove_file(file);
        }
    }
}

/// A complete file without its name.
struct Unfinished {
    file: TempPath,
    path: PathBuf,
}

/// A file that is written under another name.
struct VideoFile {
    writer: BufWriter<NamedTempFile>,
    path: PathBuf,
}

impl VideoFile {
    fn new(path: PathBuf) -> Result<Self> {
        Ok(Self { writer: BufWriter::new(whole_file::beside(&path, ".part")?), path })
    }

    fn add(&mut self, bytes: &[u8]) -> Result<()> {
        self.writer.write_all(bytes).map_err(|error| Error::io(&self.path, error))
    }

    fn finish(self) -> Result<Unfinished> {
        let Self { writer, path } = self;
        let file = writer.into_inner().map_err(|error| Error::io(&path, error.into_error()))?;
        Ok(Unfinished { file: file.into_temp_path(), path })
    }
}

/// World units from the origin up to which single precision holds a tenth of a thousandth of a unit.
const NEAR: f64 = 1e3;

/// A whole place among cameras that stand far from the origin, for them to be written from there; `None` where they do not.
fn world_offset(places: impl Iterator<Item = DVec3>) -> Option<DVec3> {
    let (mut sum, mut count, mut is_far) = (DVec3::ZERO, 0.0, false);
    for place in places {
        is_far |= place.abs().max_element() > NEAR;
        (sum, count) = (sum + place, count + 1.0);
    }
    is_far.then(|| (sum / count).round())
}

fn extent(capture: &Capture, camera: usize, job: &Job) -> Result<CameraDepths> {
    let mut extent =
        CameraDepths { nearest: 0.0, farthest: f32::INFINITY, has_sky: false, has_unknown: false };
    for frame in 0..capture.frame_count() {
        job.check()?;
        for &inverse in capture.frame(camera, frame)?.inverse_depth.as_slice() {
            if inverse > 0.0 {
                extent.nearest = extent.nearest.max(inverse);
                extent.farthest = extent.farthest.min(inverse);
            }
            extent.has_sky |= inverse == 0.0;
            extent.has_unknown |= inverse < 0.0;
        }
        job.advance(1);
    }
    Ok(extent)
}

/// The range that holds all of a camera's depths. It is a little wider, so that rounding the planes loses no end of it.
fn range(extent: CameraDepths) -> LevelRange {
    const MARGIN: f64 = 1e-3;
    let (near, far) = if extent.nearest > 0.0 {
        (
            f64::from(extent.nearest).recip() * (1.0 - MARGIN),
            f64::from(extent.farthest).recip() * (1.0 + MARGIN),
        )
    } else {
        (1.0, 2.0)
    };
    let far = if extent.has_sky || far >= 1000.0 { f64::INFINITY } else { far };
    LevelRange { near, far, order: LevelOrder::FromFar, zero_is_unknown: extent.has_unknown }
}

fn write_camera(
    content: &Path,
    index: usize,
    capture: &Capture,
    range: &LevelRange,
    job: &Job,
) -> Result<[Unfinished; 2]> {
    let size = capture.cameras[index].intrinsics.size();
    let create = |kind: &str, format: PixelFormat| {
        let name = format!("v{index}_{kind}_{}x{}_{}.yuv", size.0, size.1, format.name());
        VideoFile::new(content.join(name))
    };
    let mut texture = create("texture", TEXTURE)?;
    let mut depth = create("depth", DEPTH)?;
    for frame in 0..capture.frame_count() {
        job.check()?;
        let frame = capture.frame(index, frame)?;
        texture.add(&encode_color(frame.color.as_slice(), size, TEXTURE, ColorMatrix::default()))?;
        let inverse = frame.inverse_depth.as_slice();
        let levels = inverse.iter().map(|inverse| range.level(*inverse, DEPTH.largest())).collect();
        depth.add(&encode_levels(levels, size, DEPTH))?;
        job.advance(1);
    }
    Ok([texture.finish()?, depth.finish()?])
}

fn entry(camera: &Camera, name: &str, world_from_camera: &DAffine3, range: &LevelRange) -> SequenceCamera {
    let lens = camera.intrinsics;
    let far = if range.far.is_finite() { json!(range.far) } else { Value::from("inf") };
    SequenceCamera {
        name: name.to_owned(),
        position: world_from_camera.translation.to_array(),
        rotation: rotation(world_from_camera),
        resolution: [lens.width, lens.height],
        projection: "Perspective".to_owned(),
        focal: Some([lens.fx, lens.fy]),
        principle_point: Some([lens.cx, lens.cy]),
        depth_range: vec![json!(range.near), far],
        bit_depth_color: TEXTURE.bits,
        bit_depth_depth: DEPTH.bits,
        color_space: "YUV420".to_owned(),
        depth_color_space: "YUV420".to_owned(),
        has_invalid_depth: Some(range.zero_is_unknown),
        depthmap: Some(1),
        background: Some(0),
    }
}
