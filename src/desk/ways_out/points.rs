//! Samples as points in a binary PLY file.
//!
//! Source: Turk, *The PLY Polygon File Format*, 1994. Points are in world space; normals are unit length and zero where none is
//! known; colors are 8-bit sRGB, since that is what viewers expect of `red green blue`; `radius` is that of a disk as large as the
//! sample's pixel on its surface, in world units. Positions are doubles where cameras stand far from the origin: single precision
//! holds half a meter in maps' coordinates.

use std::io::Write;
use std::path::Path;

use glam::{DVec3, Vec3};
use half::f16;

use super::shared::{FileKind, Frames, Options, Scope, Shared, Size, WayOut, at, write_frames};
use crate::text::count_of;
use overlook_engine::capture::Camera;
use overlook_engine::color::srgb8_from_linear;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmSource;
use overlook_engine::samples::{OctNormal, PlacedSample, SampleImage, SampleSet, are_far_from_origin};
use overlook_engine::whole_file;

pub(crate) const WAY: WayOut = WayOut {
    name: "Points",
    used: "A point cloud with normals, colors and radii as PLY, for programs that measure and mesh.",
    button: "Save the points…",
    command: "points",
    about: "Samples as binary PLY: points with normal, color and radius",
    kind: |options| if options.points_of_all_frames { &POINTS_OF_FRAMES } else { &POINTS },
    size,
    write: Some((&[POINTS, POINTS_OF_FRAMES], share)),
};

/// The points of a frame.
pub(crate) const POINTS: FileKind = FileKind::of_samples("Share points", &["ply"], "points");

/// Those of every frame.
pub(crate) const POINTS_OF_FRAMES: FileKind = FileKind::of_samples("Share points in a folder", &[], "points");

fn size(scope: &Scope, options: &Options) -> Size {
    let each = if scope.is_far { POINT_BYTES } else { POINT_BYTES - 3 * 4 };
    let files = if options.points_of_all_frames { scope.frames } else { 1 };
    let points = scope.facts.placed_here * files as u64;
    let mut reason = format!("{} of {each} B", count_of(points, "point"));
    if files > 1 {
        reason = format!("{reason} in {}", counted(files, "file"));
    }
    Size::about(points as f64 * each as f64, reason)
}

fn share(path: &Path, source: &FilmSource, shared: &Shared, job: &Job) -> Result<(String, usize)> {
    let at_frame = |path: &Path, set: &SampleSet, frame| {
        let images = set.images.iter().map(|image| &**image);
        write(path, set, images.filter(move |image| image.span.contains(frame)))
    };
    let points = match shared.frames {
        Frames::One(frame) => vec![at_frame(path, &*at(source, frame, job)?, frame)?],
        Frames::Still => {
            let (set, frames) = (at(source, 0, job)?, source.frame_count());
            let still = set.images.iter().map(|image| &**image).filter(|image| image.span.len() == frames);
            vec![write(path, &set, still)?]
        }
        Frames::Every => write_frames(path, "ply", source, job, at_frame)?,
    };
    Ok(((shared.count)(points.iter().sum(), "point"), points.len()))
}

/// Bytes of a point at most: position and normal, radius, color.
const POINT_BYTES: usize = 3 * 8 + 4 * 4 + 3;

/// How positions are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Precision {
    Single,
    Double,
}

impl Precision {
    /// What the places of the cameras need.
    fn of(cameras: &[Camera]) -> Self {
        if are_far_from_origin(cameras) { Self::Double } else { Self::Single }
    }
}

/// A small disk on a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disk {
    /// World units.
    pub(crate) point_in_world: DVec3,
    /// Unit length; zero where none is known.
    pub(crate) normal_in_world: Vec3,
    /// World units.
    pub(crate) radius: f64,
    /// Linear Rec.709.
    pub(crate) color: [f32; 3],
}

/// Writes the samples of some images and returns their number. Samples at infinity have no position and are left out.
fn write<'a>(
    path: &Path,
    set: &SampleSet,
    images: impl Iterator<Item = &'a SampleImage> + Clone,
) -> Result<u64> {
    let count = images.clone().map(SampleImage::placed_count).sum();
    let points = images.flat_map(|image| points(image, &set.cameras[image.camera as usize]));
    write_points(path, &set.name, &set.cameras, count, points)
}

/// Writes so many points, around cameras, of a capture of some name, and returns their number.
pub(crate) fn write_points(
    path: &Path,
    name: &str,
    cameras: &[Camera],
    count: u64,
    points: impl Iterator<Item = Disk>,
) -> Result<u64> {
    let io = |error| Error::io(path, error);
    let precision = Precision::of(cameras);
    whole_file::write(path, |target| {
        target.write_all(header(name, count, precision).as_bytes()).map_err(io)?;
        for point in points {
            write_point(target, &point, precision).map_err(io)?;
        }
        Ok(count)
    })
}

fn header(name: &str, points: u64, precision: Precision) -> String {
    let name = name.replace(['\n', '\r'], " ");
    let kind = if precision == Precision::Double { "double" } else { "float" };
    let places = ["x", "y", "z"].map(|name| format!("property {kind} {name}\n"));
    let floats = ["nx", "ny", "nz", "radius"].map(|name| format!("property float {name}\n"));
    let bytes = ["red", "green", "blue"].map(|name| format!("property uchar {name}\n"));
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment {name}, by overlook\nelement vertex {points}\n{}{}{}end_header\n",
        places.concat(),
        floats.concat(),
        bytes.concat()
    )
}

fn points<'a>(image: &'a SampleImage, camera: &'a Camera) -> impl Iterator<Item = Disk> + 'a {
    image.placed(camera).map(move |PlacedSample { sample, ray_in_camera, depth, point_in_world }| {
        let normals = image.normal.as_ref();
        let normal_in_world = normals.map_or(Vec3::ZERO, |normals| OctNormal::decode(normals[sample.index]));
        let radius = radius(camera, ray_in_camera, depth, normal_in_world.as_dvec3());
        let color = image.color[sample.index].map(f16::to_f32);
        Disk { point_in_world, normal_in_world, radius, color }
    })
}

fn write_point(target: &mut impl Write, point: &Disk, precision: Precision) -> std::io::Result<()> {
    let Disk { point_in_world, normal_in_world, radius, color } = *point;
    let mut bytes = Vec::with_capacity(POINT_BYTES);
    match precision {
        Precision::Single => {
            bytes.extend(point_in_world.as_vec3().to_array().into_iter().flat_map(f32::to_le_bytes));
        }
        Precision::Double => bytes.extend(point_in_world.to_array().into_iter().flat_map(f64::to_le_bytes)),
    }
    let floats = normal_in_world.to_array().into_iter().chain([radius as f32]);
    bytes.extend(floats.flat_map(f32::to_le_bytes));
    bytes.extend(color.map(srgb8_from_linear));
    target.write_all(&bytes)
}

/// Radius of a disk with the area `z² cos α / (fx fy cos θ)`, without `z` of an orthographic camera, of a pixel on its surface, which faces the camera if it has no
/// normal.
fn radius(camera: &Camera, ray: DVec3, z: f64, normal_in_world: DVec3) -> f64 {
    /// The smallest cosine of the viewing angle, as `pruning.cosine_floor`.
    const COSINE_FLOOR: f64 = 0.1;
    let direction = (camera.world_from_camera.matrix3 * ray).normalize_or_zero();
    let cos_off_axis = 1.0 / ray.length();
    let cos_incidence = if normal_in_world == DVec3::ZERO {
        1.0
    } else {
        direction.dot(normal_in_world).abs().max(COSINE_FLOOR)
    };
    let z = if camera.intrinsics.is_orthographic() { 1.0 } else { z };
    let area = z * z * cos_off_axis / (camera.intrinsics.fx * camera.intrinsics.fy * cos_incidence);
    (area / std::f64::consts::PI).sqrt()
}
