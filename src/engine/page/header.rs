//! What the page knows besides its samples, as JSON.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::{DAffine3, DVec3};
use serde::Serialize;

use super::chunks::{BEST, ImageHeader, Packed, gzipped};
use super::options::{PageOptions, PageScalarBar};
use crate::capture::{Intrinsics, pivot};
use crate::color::srgb8_from_linear;
use crate::error::Result;
use crate::median::median_f32;
use crate::render::sky_map;
use crate::samples::SampleSet;

/// Frames a second where nobody says how many.
const FRAMES_PER_SECOND: f64 = 24.0;

/// Rows of the map of the sky, which has twice as many columns.
const SKY_ROWS: usize = 64;

#[derive(Serialize)]
pub(super) struct Header {
    title: String,
    paragraphs: Vec<String>,
    up: [f64; 3],
    /// What the cameras look at.
    pivot: [f64; 3],
    frames_per_second: f64,
    /// Numbers of the frames in the capture.
    frames: Vec<i64>,
    /// Samples this close behind the nearest one are blended with it, in footprints.
    depth_tolerance: f32,
    cameras: Vec<CameraHeader>,
    path: Option<PathHeader>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scalar_bar: Option<PageScalarBar>,
    sky: Option<SkyHeader>,
    /// For each chunk, its images.
    chunks: Vec<Vec<ImageHeader>>,
}

#[derive(Serialize)]
struct CameraHeader {
    name: String,
    lens: [f64; 6],
    /// Columns of the matrix from camera space to world space: its axes, then its place.
    world_from_camera: [f64; 12],
    depth_shift: u32,
}

#[derive(Serialize)]
struct PathHeader {
    first_frame: usize,
    lens: [f64; 6],
    poses: Vec<[f64; 12]>,
}

/// 8-bit sRGB by direction: rows from straight up along z to straight down, columns by the angle about z from −x on.
#[derive(Serialize)]
struct SkyHeader {
    /// Share of the samples at the first frame.
    share: f32,
    rows: usize,
    /// Each byte less the one three before it, gzip, base64.
    colors: String,
}

/// Width, height, focal lengths and principal point.
fn lens(lens: &Intrinsics) -> [f64; 6] {
    [f64::from(lens.width), f64::from(lens.height), lens.fx, lens.fy, lens.cx, lens.cy]
}

/// The colors at infinity at the first frame, as [`SkyHeader`] has them; `None` without a sky.
pub(super) fn sky_of(set: &SampleSet) -> Result<Option<Vec<u8>>> {
    let directions: Vec<glam::Vec3> = (0..SKY_ROWS)
        .flat_map(|row| {
            let (sin, cos) = ((row as f32 + 0.5) / SKY_ROWS as f32 * std::f32::consts::PI).sin_cos();
            (0..2 * SKY_ROWS).map(move |column| {
                let around = ((column as f32 + 0.5) / SKY_ROWS as f32 - 1.0) * std::f32::consts::PI;
                glam::Vec3::new(sin * around.cos(), sin * around.sin(), cos)
            })
        })
        .collect();
    let colors = sky_map(set, 0, &directions)?;
    Ok(colors.map(|colors| colors.into_iter().flat_map(|color| color.map(srgb8_from_linear)).collect()))
}

/// The header of a page.
pub(super) fn of(
    set: &SampleSet,
    options: &PageOptions,
    sky: Option<&[u8]>,
    packed: &Packed,
) -> Result<Header> {
    let rate = options.frames_per_second;
    let paragraphs = options.text.as_deref().unwrap_or_default().split("\n\n");
    let sky = sky.map(|sky| {
        let residuals: Vec<u8> =
            (0..sky.len()).map(|at| sky[at].wrapping_sub(if at < 3 { 0 } else { sky[at - 3] })).collect();
        Ok(SkyHeader {
            share: sky_share(set),
            rows: SKY_ROWS,
            colors: STANDARD.encode(gzipped(&residuals, BEST, &set.name)?),
        })
    });
    Ok(Header {
        title: options.title.clone().unwrap_or_else(|| set.name.clone()),
        paragraphs: paragraphs.map(|text| text.trim().to_owned()).filter(|text| !text.is_empty()).collect(),
        up: set.up_in_world.to_array(),
        pivot: looked_at(set).to_array(),
        frames_per_second: if rate > 0.0 { rate } else { FRAMES_PER_SECOND },
        frames: set.frame_numbers.clone(),
        depth_tolerance: set.settings.render.depth_tolerance,
        cameras: set
            .cameras
            .iter()
            .zip(&packed.shifts)
            .map(|(camera, &depth_shift)| CameraHeader {
                name: camera.name.clone(),
                lens: lens(&camera.intrinsics),
                world_from_camera: camera.world_from_camera.to_cols_array(),
                depth_shift,
            })
            .collect(),
        path: options.path.as_ref().map(|path| PathHeader {
            first_frame: path.first_frame,
            lens: lens(&path.lens),
            poses: path.poses.iter().map(DAffine3::to_cols_array).collect(),
        }),
        scalar_bar: options.scalar_bar.clone(),
        sky: sky.transpose()?,
        chunks: packed.chunks.iter().map(|chunk| chunk.images.clone()).collect(),
    })
}

/// The share of samples that are at infinity at the first frame.
fn sky_share(set: &SampleSet) -> f32 {
    let depths: Vec<f32> = set.images_at(0).flat_map(|image| image.inverse_depths()).collect();
    let far = depths.iter().filter(|depth| **depth == 0.0).count();
    far as f32 / depths.len().max(1) as f32
}

/// What the cameras look at, in world space.
fn looked_at(set: &SampleSet) -> DVec3 {
    let mut depths: Vec<f32> = set.images.first().map(|image| image.inverse_depths()).unwrap_or_default();
    depths.retain(|depth| *depth > 0.0);
    pivot(&set.cameras, median_f32(&mut depths).map_or(1.0, |depth| 1.0 / f64::from(depth)))
}
