//! From planes of numbers to a [`Frame`] in the program's conventions.
//!
//! A pixel is *invalid* (no depth, takes part in nothing, is counted) where its depth is nonsense, where its color is
//! not finite, and where nothing was hit behind a transparent film (alpha 0), since it then has neither depth nor
//! color. Where nothing was hit but color is there, the pixel is a sample at infinity.

use glam::{DMat3, DVec2, DVec3};
use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::capture::{Camera, Frame, INVALID_INVERSE_DEPTH};
use crate::error::{Error, Result};
use crate::grid::Grid;

/// A normal must lean this far away from the viewer, as a cosine, before it counts as the back of a two-sided surface
/// and is turned. Smooth shading tips normals slightly past the silhouette; turning those would be worse than leaving.
const BACK_FACING_COSINE: f64 = 0.25;

/// The space that recorded normals are in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum NormalSpace {
    /// World space.
    #[default]
    World,
    /// The camera's own, with OpenGL's axes: x right, y up, z toward the viewer.
    Camera,
}

impl NormalSpace {
    /// The space by its name in the manifest.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "world" => Self::World,
            "camera" => Self::Camera,
            _ => return None,
        })
    }
}

/// The planes of one picture, row-major, all of the camera's size.
#[derive(Clone, Debug)]
pub struct Layers {
    /// Linear red, green, blue; not yet checked.
    pub color: [Vec<f32>; 3],
    /// Coverage, where the picture has it.
    pub alpha: Option<Vec<f32>>,
    /// As [`Frame::inverse_depth`].
    pub inverse_depth: Vec<f32>,
    /// As [`Frame::depth_step_relative`].
    pub depth_step_relative: f32,
    /// Normals as recorded, x, y, z, any length, and the space they are in.
    pub normal: Option<([Vec<f32>; 3], NormalSpace)>,
    /// What the depth was read from, for messages: a channel's or a file's name.
    pub depth_name: String,
}

impl Layers {
    /// Makes the frame; `place` names file and frame in errors.
    ///
    /// # Errors
    /// `Invalid` where not a single pixel has a depth.
    pub fn into_frame(mut self, camera: &Camera, place: &str) -> Result<Frame> {
        let (width, height) = camera.intrinsics.size();
        let without_color = self.invalidate_pixels_without_color();
        if self.inverse_depth.iter().all(|&inverse| inverse < 0.0) {
            let color_share = 100.0 * without_color as f64 / self.inverse_depth.len().max(1) as f64;
            return Err(Error::invalid(
                place,
                format!(
                    "not one pixel of channel '{}' is a depth ({color_share:.0} % have no color either); render it again",
                    self.depth_name
                ),
            ));
        }
        let normal_in_world = self.normal.as_ref().map(|(planes, space)| {
            Grid::from_vec(width, height, world_normals(planes, *space, &self.inverse_depth, camera))
        });
        Ok(Frame {
            color: Grid::from_vec(width, height, finite_halves(&self.color)),
            inverse_depth: Grid::from_vec(width, height, self.inverse_depth),
            normal_in_world,
            depth_step_relative: self.depth_step_relative,
        })
    }

    /// Marks pixels whose color is not finite or is not there as invalid, and says how many there were.
    fn invalidate_pixels_without_color(&mut self) -> usize {
        let [red, green, blue] = &self.color;
        let mut without_color = 0;
        for (((inverse, r), g), b) in self.inverse_depth.iter_mut().zip(red).zip(green).zip(blue) {
            let is_finite = r.is_finite() & g.is_finite() & b.is_finite();
            *inverse = if is_finite { *inverse } else { INVALID_INVERSE_DEPTH };
            without_color += usize::from(!is_finite);
        }
        for (inverse, alpha) in self.inverse_depth.iter_mut().zip(self.alpha.iter().flatten()) {
            if *alpha <= 0.0 && *inverse == 0.0 {
                *inverse = INVALID_INVERSE_DEPTH;
                without_color += 1;
            }
        }
        without_color
    }
}

/// Pixels whose color is narrowed at a time: alone, each half float would ask the processor what it can do.
const NARROWED: usize = 256;

/// The nearest half floats, channel by channel in turn; beyond the largest one the largest, and 0 where there is no color.
fn finite_halves(planes: &[Vec<f32>; 3]) -> Vec<[f16; 3]> {
    let mut color = vec![[f16::ZERO; 3]; planes[0].len()];
    let mut finite = [0.0; NARROWED];
    let mut halves = [f16::ZERO; NARROWED];
    for (index, color) in color.chunks_mut(NARROWED).enumerate() {
        for (channel, plane) in planes.iter().enumerate() {
            for (finite, value) in finite.iter_mut().zip(&plane[index * NARROWED..]) {
                let within = value.max(f16::MIN.to_f32_const()).min(f16::MAX.to_f32_const());
                *finite = if value.is_finite() { within } else { 0.0 };
            }
            halves.convert_from_f32_slice(&finite);
            for (color, half) in color.iter_mut().zip(&halves) {
                color[channel] = *half;
            }
        }
    }
    color
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
        NormalSpace::Camera => world_from_camera * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)),
    };
    let width = camera.intrinsics.size().0;
    let [xs, ys, zs] = planes;
    (0..inverse_depth.len())
        .map(|index| {
            let recorded = DVec3::new(f64::from(xs[index]), f64::from(ys[index]), f64::from(zs[index]));
            let Some(normal) = (world_from_recorded * recorded).try_normalize() else { return [0.0; 3] };
            if inverse_depth[index] <= 0.0 {
                return [0.0; 3];
            }
            let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let ray = world_from_camera * camera.intrinsics.ray_in_camera(pixel);
            let is_back = normal.dot(ray) > BACK_FACING_COSINE * ray.length();
            (if is_back { -normal } else { normal }).as_vec3().to_array()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;

    fn camera() -> Camera {
        let intrinsics = Intrinsics::from_horizontal_angle(4, 1, 0.5);
        Camera::look_at("c", intrinsics, DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO, DVec3::Z)
    }

    fn layers() -> Layers {
        Layers {
            color: [vec![0.5; 4], vec![0.25; 4], vec![1e9; 4]],
            alpha: Some(vec![1.0, 0.0, 1.0, 0.0]),
            inverse_depth: vec![0.5, 0.0, 0.0, 0.25],
            depth_step_relative: 0.0,
            normal: None,
            depth_name: "Z".into(),
        }
    }

    #[test]
    fn sky_is_a_sample_unless_the_film_is_transparent_there() {
        let frame = layers().into_frame(&camera(), "test").unwrap();
        assert_eq!(frame.inverse_depth.as_slice(), [0.5, -1.0, 0.0, 0.25]);
        assert_eq!(frame.color[(0, 0)], [f16::from_f32(0.5), f16::from_f32(0.25), f16::MAX]);
    }

    #[test]
    fn a_pixel_whose_color_is_not_a_number_is_invalid() {
        let mut layers = layers();
        layers.color[1][0] = f32::NAN;
        let frame = layers.into_frame(&camera(), "test").unwrap();
        assert_eq!(frame.invalid_pixels(), 2);
        assert_eq!(frame.color[(0, 0)][1], f16::ZERO);
    }

    #[test]
    fn a_plane_without_any_depth_is_refused_by_name() {
        let mut layers = layers();
        layers.inverse_depth = vec![INVALID_INVERSE_DEPTH; 4];
        let error = layers.into_frame(&camera(), "cam0/0003.exr").unwrap_err().to_string();
        assert!(error.contains("cam0/0003.exr") && error.contains("'Z'") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn camera_space_normals_reach_the_world_and_face_the_camera() {
        let mut layers = layers();
        layers.inverse_depth = vec![0.5; 4];
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
