//! Writing a capture as a sequence that TMIV and RVS read.
//!
//! ```text
//! DIR/NAME.json                                       written last
//! DIR/NAME/v0_texture_640x480_yuv420p10le.yuv …       all frames, one after the other
//! DIR/NAME/v0_depth_640x480_yuv420p16le.yuv …
//! ```

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use glam::{DAffine3, DQuat, DVec3};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::sequence::{SequenceCamera, SequenceFile, rotation};
use crate::capture::camera::Camera;
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
/// `Io` where something cannot be written, `Unsupported` for pictures of odd width or height, which 4:2:0 has not, whatever loading
/// a frame gives, and [`Error::Cancelled`].
pub fn write_sequence(folder: &Path, name: &str, capture: &Capture, job: &Job) -> Result<()> {
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
    std::fs::create_dir_all(&content).map_err(|error| Error::io(&content, error))?;
    // Video of one capture must never be left beside the cameras of another.
    let path = folder.join(format!("{name}.json"));
    match std::fs::remove_file(&path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(&path, error)),
        _ => (),
    }
    let z_from_up = DAffine3::from_quat(DQuat::from_rotation_arc(capture.up_in_world, DVec3::Z));
    let cameras = (0..capture.cameras.len()).into_par_iter().map(|index| {
        let range = range(extent(capture, index, job)?);
        let camera = &capture.cameras[index];
        write_camera(&content, index, capture, &range, job)?;
        Ok(entry(camera, &format!("v{index}"), &(z_from_up * camera.world_from_camera), &range))
    });
    let cameras = cameras.collect::<Result<Vec<SequenceCamera>>>()?;
    let sequence = SequenceFile {
        version: json!("4.0"),
        content_name: name.to_owned(),
        bounding_box_center: vec![0.0; 3],
        fps: 30.0,
        frames_number: capture.frame_count() as u64,
        lengths_in_meters: Some(true),
        source_camera_names: Some(cameras.iter().map(|camera| camera.name.clone()).collect()),
        frame_ranges: Vec::new(),
        cameras,
    };
    whole_file::write(&path, |writer| {
        serde_json::to_writer_pretty(writer, &sequence)
            .map_err(|error| Error::io(&path, std::io::Error::from(error)))
    })
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
) -> Result<()> {
    let size = capture.cameras[index].intrinsics.size();
    let create = |kind: &str, format: PixelFormat| {
        let path = content.join(format!("v{index}_{kind}_{}x{}_{}.yuv", size.0, size.1, format.name()));
        let file = File::create(&path).map_err(|error| Error::io(&path, error))?;
        Ok((BufWriter::new(file), path))
    };
    let (mut texture, texture_path) = create("texture", TEXTURE)?;
    let (mut depth, depth_path) = create("depth", DEPTH)?;
    for frame in 0..capture.frame_count() {
        job.check()?;
        let frame = capture.frame(index, frame)?;
        let colors = encode_color(frame.color.as_slice(), size, TEXTURE, ColorMatrix::default());
        texture.write_all(&colors).map_err(|error| Error::io(&texture_path, error))?;
        let inverse = frame.inverse_depth.as_slice();
        let levels = inverse.iter().map(|inverse| range.level(*inverse, DEPTH.largest())).collect();
        depth
            .write_all(&encode_levels(levels, size, DEPTH))
            .map_err(|error| Error::io(&depth_path, error))?;
        job.advance(1);
    }
    texture.flush().map_err(|error| Error::io(&texture_path, error))?;
    depth.flush().map_err(|error| Error::io(&depth_path, error))
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
