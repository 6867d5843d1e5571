//! Samples as points in a binary PLY file.
//!
//! Source: Turk, *The PLY Polygon File Format*, 1994. Points are in world space; normals are unit length and zero where none is
//! known; colors are 8-bit sRGB, since that is what viewers expect of `red green blue`; `radius` is that of a disk as large as the
//! sample's pixel on its surface, in world units. Positions are doubles where cameras stand far from the origin: single precision
//! holds half a meter in maps' coordinates.

use std::io::Write;
use std::path::Path;

use glam::DVec3;

use overlook_engine::capture::Camera;
use overlook_engine::color::srgb8_from_linear;
use overlook_engine::error::{Error, Result};
use overlook_engine::samples::{OctNormal, PlacedSample, SampleImage, SampleSet, are_far_from_origin};
use overlook_engine::whole_file;

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

/// Writes the samples of some images and returns their number. Samples at infinity have no position and are left out.
pub(crate) fn write<'a>(
    path: &Path,
    set: &SampleSet,
    images: impl Iterator<Item = &'a SampleImage> + Clone,
) -> Result<u64> {
    let io = |error| Error::io(path, error);
    let points = images.clone().map(SampleImage::placed_count).sum();
    let precision = Precision::of(&set.cameras);
    whole_file::write(path, |target| {
        target.write_all(header(&set.name, points, precision).as_bytes()).map_err(io)?;
        for image in images {
            write_points(target, image, &set.cameras[image.camera as usize], precision).map_err(io)?;
        }
        Ok(points)
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

fn write_points(
    target: &mut impl Write,
    image: &SampleImage,
    camera: &Camera,
    precision: Precision,
) -> std::io::Result<()> {
    for PlacedSample { sample, ray_in_camera, depth, point_in_world } in image.placed(camera) {
        let normals = image.normal.as_ref();
        let normal = normals.map_or(glam::Vec3::ZERO, |normals| OctNormal::decode(normals[sample.index]));
        let mut bytes = Vec::with_capacity(POINT_BYTES);
        match precision {
            Precision::Single => {
                bytes.extend(point_in_world.as_vec3().to_array().into_iter().flat_map(f32::to_le_bytes));
            }
            Precision::Double => {
                bytes.extend(point_in_world.to_array().into_iter().flat_map(f64::to_le_bytes));
            }
        }
        let radius = radius(camera, ray_in_camera, depth, normal.as_dvec3());
        let floats = normal.to_array().into_iter().chain([radius as f32]);
        bytes.extend(floats.flat_map(f32::to_le_bytes));
        bytes.extend(image.color[sample.index].map(|channel| srgb8_from_linear(channel.to_f32())));
        target.write_all(&bytes)?;
    }
    Ok(())
}

/// Radius of a disk with the area `z² cos α / (fx fy cos θ)` of a pixel on its surface, which faces the camera if it has no
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
    let area = z * z * cos_off_axis / (camera.intrinsics.fx * camera.intrinsics.fy * cos_incidence);
    (area / std::f64::consts::PI).sqrt()
}
