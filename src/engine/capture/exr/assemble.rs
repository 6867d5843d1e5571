//! From planes of numbers to a [`Frame`] in the program's conventions.
//!
//! A pixel is *invalid* (no depth, takes part in nothing, is counted) where its depth is nonsense, where its color is
//! not finite, and where it is transparent. Where nothing was hit but color is there, the pixel is a sample at infinity.

use glam::{DMat3, DVec2, DVec3};

use super::color_planes::ColorPlanes;
use super::transparency::AlphaPlane;
use crate::capture::camera::{Camera, Intrinsics};
use crate::capture::frame::Frame;
use crate::capture::values::Values;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::simd::{self, LANES, VectorLoop};

/// A normal must lean this far away from the viewer, as a cosine, before it counts as the back of a two-sided surface
/// and is turned. Smooth shading tips normals slightly past the silhouette; turning those would be worse than leaving.
const BACK_FACING_COSINE: f64 = 0.25;

/// The space that recorded normals are in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum NormalSpace {
    /// World space.
    #[default]
    World,
    /// The camera's own, with OpenGL's axes: x right, y up, z toward the viewer.
    Camera,
    /// The camera's own, with `OpenCV`'s axes: x right, y down, z away from the viewer.
    CameraOpenCv,
}

impl NormalSpace {
    /// The space by its name in the manifest.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "world" => Self::World,
            "camera" => Self::Camera,
            "camera_opencv" => Self::CameraOpenCv,
            _ => return None,
        })
    }
}

/// Why pixels of a depth channel may be unusable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum DepthTrouble {
    /// No reason is known: unusable depth is an error.
    #[default]
    Unknown,
    /// A sensor measured nothing, which happens.
    MayBeUnmeasured,
    /// Every distance is negative.
    Negative,
}

/// The planes of one picture, row-major, all of the camera's size.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    /// Linear red, green, blue; not yet checked.
    pub(crate) color: ColorPlanes,
    /// Where the picture has it, and it counts.
    pub(crate) alpha: Option<AlphaPlane>,
    /// As [`Frame::inverse_depth`].
    pub(crate) inverse_depth: Vec<f32>,
    /// As [`Frame::depth_step_relative`].
    pub(crate) depth_step_relative: f32,
    /// Normals as recorded, x, y, z, any length, and the space they are in.
    pub(crate) normal: Option<([Vec<f32>; 3], NormalSpace)>,
    /// What the depth was read from, for messages: a channel's or a file's name.
    pub(crate) depth_name: String,
    /// Why pixels of it may be unusable.
    pub(crate) depth_trouble: DepthTrouble,
}

impl Layers {
    /// Makes the frame; `place` names file and frame in errors. A transparent film without an object in view has no sample,
    /// nor has a sensor that measured nothing: both are no errors.
    ///
    /// # Errors
    /// `Invalid` where not a single pixel has a depth, or depth is measured backwards.
    pub(crate) fn into_frame(mut self, camera: &Camera, place: &str) -> Result<Frame> {
        let (width, height) = camera.intrinsics.size();
        let (mut color, without_color) = self.color.into_halves(&mut self.inverse_depth);
        if self.depth_trouble == DepthTrouble::Negative {
            let what = format!(
                "every distance in channel '{}' is negative; depth is the distance forward and must be positive",
                self.depth_name
            );
            return Err(Error::invalid(place, what));
        }
        let is_unmeasured =
            self.depth_trouble == DepthTrouble::MayBeUnmeasured && without_color < self.inverse_depth.len();
        if !is_unmeasured && self.inverse_depth.iter().all(|&inverse| inverse < 0.0) {
            let color_share = 100.0 * without_color as f64 / self.inverse_depth.len().max(1) as f64;
            let what = format!(
                "not one pixel of channel '{}' is a depth ({color_share:.0} % have no color either); render it again",
                self.depth_name
            );
            return Err(Error::invalid(place, what));
        }
        if let Some(alpha) = &self.alpha {
            alpha.cut_out(&mut color, &mut self.inverse_depth);
        }
        let normal_in_world = self.normal.as_ref().map(|(planes, space)| {
            Grid::from_vec(width, height, world_normals(planes, *space, &self.inverse_depth, camera))
        });
        Ok(Frame {
            color: Grid::from_vec(width, height, color),
            inverse_depth: Grid::from_vec(width, height, self.inverse_depth),
            normal_in_world,
            depth_step_relative: self.depth_step_relative,
            values: Values::default(),
        })
    }
}

/// Unit normals toward the camera; zero where nothing was hit or none is recorded. Blender filters normals as it does
/// color: a short one is a blend across a silhouette, whose direction is still the best guess.
fn world_normals(
    planes: &[Vec<f32>; 3],
    space: NormalSpace,
    inverse_depth: &[f32],
    camera: &Camera,
) -> Vec<[f32; 3]> {
    let world_from_camera = camera.world_from_camera.matrix3;
    let world_from_recorded = match space {
        NormalSpace::World => DMat3::IDENTITY,
        NormalSpace::CameraOpenCv => world_from_camera,
        NormalSpace::Camera => world_from_camera * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)),
    };
    let width = camera.intrinsics.size().0.max(1);
    let mut normals = vec![[0.0; 3]; inverse_depth.len()];
    for (y, normals) in normals.chunks_mut(width).enumerate() {
        let row = y * width..y * width + normals.len();
        simd::run(NormalRow {
            recorded: planes.each_ref().map(|plane| &plane[row.clone()]),
            inverse_depth: &inverse_depth[row.clone()],
            world_from_recorded,
            world_from_camera,
            intrinsics: camera.intrinsics,
            y,
            normals,
        });
    }
    normals
}

/// One row of normals.
struct NormalRow<'a> {
    recorded: [&'a [f32]; 3],
    inverse_depth: &'a [f32],
    world_from_recorded: DMat3,
    world_from_camera: DMat3,
    intrinsics: Intrinsics,
    y: usize,
    normals: &'a mut [[f32; 3]],
}

impl VectorLoop for NormalRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            recorded,
            inverse_depth,
            world_from_recorded,
            world_from_camera,
            intrinsics,
            y: row,
            normals,
        } = self;
        let count = normals.len().min(inverse_depth.len());
        for first in (0..count).step_by(LANES) {
            let lanes = LANES.min(count - first);
            let mut found = [[0.0_f32; LANES]; 3];
            let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let mut w = [0.0; LANES];
            x[..lanes].copy_from_slice(&recorded[0][first..first + lanes]);
            y[..lanes].copy_from_slice(&recorded[1][first..first + lanes]);
            z[..lanes].copy_from_slice(&recorded[2][first..first + lanes]);
            w[..lanes].copy_from_slice(&inverse_depth[first..first + lanes]);
            for i in 0..LANES {
                let recorded = DVec3::new(f64::from(x[i]), f64::from(y[i]), f64::from(z[i]));
                let normal = world_from_recorded * recorded;
                let reciprocal = 1.0 / normal.length();
                let normal = normal * reciprocal;
                let pixel = DVec2::new((first + i) as f64 + 0.5, row as f64 + 0.5);
                let ray = world_from_camera * intrinsics.ray_in_camera(pixel);
                let is_back = normal.dot(ray) > BACK_FACING_COSINE * ray.length();
                let is_there = (reciprocal > 0.0) & (reciprocal < f64::INFINITY) & (w[i] > 0.0);
                let side = if is_back { -1.0 } else { 1.0 };
                found[0][i] = if is_there { (normal.x * side) as f32 } else { 0.0 };
                found[1][i] = if is_there { (normal.y * side) as f32 } else { 0.0 };
                found[2][i] = if is_there { (normal.z * side) as f32 } else { 0.0 };
            }
            for (i, normal) in normals[first..first + lanes].iter_mut().enumerate() {
                *normal = [found[0][i], found[1][i], found[2][i]];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;

    fn camera() -> Camera {
        let intrinsics = Intrinsics::from_horizontal_angle(4, 1, 0.5);
        Camera::look_at("c", intrinsics, DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO, DVec3::Z)
    }

    fn alpha(values: &[f32]) -> AlphaPlane {
        AlphaPlane { values: values.to_vec(), is_associated: true }
    }

    fn layers() -> Layers {
        Layers {
            color: ColorPlanes::Single([vec![0.5; 4], vec![0.25; 4], vec![1e9; 4]]),
            alpha: Some(alpha(&[1.0, 0.0, 1.0, 0.0])),
            inverse_depth: vec![0.5, 0.0, 0.0, 0.25],
            depth_step_relative: 0.0,
            normal: None,
            depth_name: "Z".into(),
            depth_trouble: DepthTrouble::default(),
        }
    }

    #[test]
    fn what_is_transparent_is_no_sample_and_opaque_sky_is_one() {
        let frame = layers().into_frame(&camera(), "test").unwrap();
        assert_eq!(frame.inverse_depth.as_slice(), [0.5, -1.0, 0.0, -1.0]);
        assert_eq!(frame.color[(0, 0)], [f16::from_f32(0.5), f16::from_f32(0.25), f16::MAX]);
    }

    #[test]
    fn a_pixel_whose_color_is_not_a_number_is_invalid() {
        let mut layers = layers();
        layers.color = ColorPlanes::Single([vec![0.5; 4], vec![f32::NAN, 0.25, 0.25, 0.25], vec![1.0; 4]]);
        let frame = layers.into_frame(&camera(), "test").unwrap();
        assert_eq!(frame.invalid_pixels(), 3);
        assert_eq!(frame.color[(0, 0)][1], f16::ZERO);
    }

    #[test]
    fn camera_space_normals_reach_the_world_and_face_the_camera() {
        let mut layers = layers();
        (layers.inverse_depth, layers.alpha) = (vec![0.5; 4], None);
        // Toward the viewer at half length, away from the viewer, up in the picture, none.
        let planes = [vec![0.0; 4], vec![0.0, 0.0, 1.0, 0.0], vec![0.5, -1.0, 0.0, 0.0]];
        layers.normal = Some((planes, NormalSpace::Camera));
        let frame = layers.into_frame(&camera(), "test").unwrap();
        let normals = frame.normal_in_world.unwrap();
        // The camera looks along +y with z up.
        let expected = [[0.0, -1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
        for (normal, expected) in normals.as_slice().iter().zip(expected) {
            for axis in 0..3 {
                assert!((normal[axis] - expected[axis]).abs() < 1e-6, "{normal:?} {expected:?}");
            }
        }
    }
}
