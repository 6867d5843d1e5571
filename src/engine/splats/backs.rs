//! A second layer behind surfaces, which keeps them opaque.
//!
//! Splats that are narrow enough for a sharp picture leave gaps between them, and viewers that lower the opacity of what is smaller than
//! a pixel make them translucent: what is behind shows through. Wide ones hide it, but the nearest of them covers its neighbors, which
//! moves edges and blurs. So each two by two pixels of a surface get one wide opaque splat of their mean color a little behind
//! it. Where a surface ends there is none, as it would stick out.

use glam::{Vec3, Vec4};

use super::gaussian::Gaussian;
use super::space::is_near;
use crate::capture::Camera;
use crate::samples::SampleImage;

/// The radii are this many times those of the samples. Measured at true pictures of a room of nine cameras, 640 × 480, by the published
/// formula with its anti-aliasing factor, where our pictures have 35.6 dB: with backs 30.5. A prototype of the same layers gave 23.9 for
/// samples alone and 28.4 for wider ones alone, and lost 0.3 to 0.7 dB with backs half or twice as far behind, 0.4 with a third wider ones.
const WIDER: f32 = 3.0;

/// A back lies behind its surface by this many times the samples' radius.
const BEHIND: f32 = 3.5;

/// More than any sample's: the lowest that all formats keep apart from it.
const OPACITY: f32 = 0.999;

/// Of the sixteen pixels around, so many must be samples: others may be those of another camera.
const LEAST_AROUND: usize = 10;

/// On a plane inverse depths are linear. They may differ from that by this many pixels' spread.
const UNEVENNESS: f32 = 2.0;

/// The pixels of an image: inverse depth, 0 where none counts, and which of its placed samples it is.
struct Pixels {
    width: usize,
    height: usize,
    cells: Vec<(f32, u32)>,
}

impl Pixels {
    fn of(image: &SampleImage, camera: &Camera) -> Self {
        let (width, height) = camera.intrinsics.size();
        let mut cells = vec![(0.0, 0); width * height];
        let depths = image.inverse_depths();
        let near = image.samples().filter(|sample| is_near(depths[sample.index]));
        for (nth, sample) in near.enumerate() {
            let counts = sample.x < width && sample.y < height && !image.is_doubtful(sample.x, sample.y);
            if counts {
                cells[sample.y * width + sample.x] = (depths[sample.index], nth as u32);
            }
        }
        Self { width, height, cells }
    }

    /// Inverse depths of the four by four pixels around a block of two by two, row by row; 0 where there is none.
    fn around(&self, x: usize, y: usize) -> [f32; 16] {
        std::array::from_fn(|at| {
            let (x, y) = ((x + at % 4).wrapping_sub(1), (y + at / 4).wrapping_sub(1));
            if x < self.width && y < self.height { self.cells[y * self.width + x].0 } else { 0.0 }
        })
    }
}

/// The blocks of an image's pixels that get a back: which of its placed samples they consist of.
pub(super) fn blocks(image: &SampleImage, camera: &Camera) -> Vec<[u32; 4]> {
    let pixels = Pixels::of(image, camera);
    let unevenness = UNEVENNESS / camera.intrinsics.fx.min(camera.intrinsics.fy) as f32;
    let corners = (0..pixels.height.saturating_sub(1))
        .step_by(2)
        .flat_map(|y| (0..pixels.width.saturating_sub(1)).step_by(2).map(move |x| (x, y)));
    let has_back = |&(x, y): &(usize, usize)| is_inside(&pixels.around(x, y), unevenness);
    let of_block = |(x, y): (usize, usize)| {
        let first = y * pixels.width + x;
        [first, first + 1, first + pixels.width, first + pixels.width + 1].map(|at| pixels.cells[at].1)
    };
    corners.filter(has_back).map(of_block).collect()
}

/// Whether the inner four of some inverse depths are all there, in the midst of one even surface.
fn is_inside(around: &[f32; 16], unevenness: f32) -> bool {
    let is_whole = [5, 6, 9, 10].iter().all(|at| around[*at] > 0.0);
    if !is_whole || around.iter().filter(|depth| **depth > 0.0).count() < LEAST_AROUND {
        return false;
    }
    // In rows, then in columns.
    let triples = (0..4).flat_map(|line| [0, 1].map(|at| [(4 * line + at, 1), (4 * at + line, 4)])).flatten();
    triples.into_iter().all(|(first, step)| {
        let [before, here, after] = [0, 1, 2].map(|nth| around[first + nth * step]);
        let is_known = before.min(here).min(after) > 0.0;
        !is_known || (before - 2.0 * here + after).abs() <= unevenness * here
    })
}

/// The splat behind those of a block.
pub(super) fn back(block: [Gaussian; 4]) -> Gaussian {
    let mean = |of: fn(&Gaussian) -> Vec3| block.iter().map(of).sum::<Vec3>() / 4.0;
    let radii = mean(|splat| splat.radii);
    let rotation = block.iter().fold(Vec4::ZERO, |sum, splat| {
        let parts = Vec4::from(splat.rotation);
        sum + if parts.dot(Vec4::from(block[0].rotation)) < 0.0 { -parts } else { parts }
    });
    let rotation = glam::Quat::from_vec4(rotation).normalize();
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    Gaussian {
        center: mean(|splat| splat.center) - rotation * Vec3::Z * (BEHIND * (radii.x * radii.y).sqrt()),
        rotation,
        radii: radii * WIDER,
        color: mean(|splat| Vec3::from(splat.color)).to_array(),
        opacity: OPACITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::samples::{PlacedSample, Sample};
    use crate::splats::gaussian::Look;
    use crate::splats::space::{Axes, Space};
    use glam::{DAffine3, DVec2, DVec3, Mat2, Vec2};

    /// Pixels along each side of a wall.
    const SIDE: u32 = 32;

    /// The splats of a wall that a camera looks straight at, one unit a pixel, with y up, z back and the middle at the origin.
    fn wall() -> Vec<Gaussian> {
        let intrinsics = Intrinsics::centered(SIDE, SIDE, 1000.0);
        let world_from_camera = DAffine3::from_translation(DVec3::new(0.0, 0.0, -1000.0));
        let camera = Camera { name: "c".into(), intrinsics, world_from_camera };
        let look = Look { normal_in_world: Vec3::NEG_Z, color: [0.5; 3], is_doubtful: false };
        let splat = |(x, y): (u32, u32)| {
            let ray_in_camera =
                camera.intrinsics.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let point_in_world = camera.world_from_camera.transform_point3(ray_in_camera * 1000.0);
            let sample = Sample { x: x as usize, y: y as usize, index: 0 };
            let placed = PlacedSample { sample, ray_in_camera, depth: 1000.0, point_in_world };
            Gaussian::of_sample(&placed, &camera, &look, &Space::upright(Axes::BackUp))
        };
        let blocks = (0..SIDE * SIDE / 4).map(|nth| (nth % (SIDE / 2) * 2, nth / (SIDE / 2) * 2));
        let of_block = |(x, y): (u32, u32)| [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(splat);
        blocks.map(of_block).flat_map(|block| [&block[..], &[back(block)]].concat()).collect()
    }

    /// How much of what is behind a place of a picture shows, by the published formula: `axes` are the picture's, in pixels a unit.
    fn shown_behind(splats: &[Gaussian], axes: [Vec3; 2], at: Vec2, is_antialiased: bool) -> f32 {
        let left = splats.iter().map(|splat| {
            let mut covariance = Mat2::ZERO;
            for (axis, radius) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(splat.radii.to_array()) {
                let side = Vec2::from(axes.map(|to| to.dot(splat.rotation * axis) * radius));
                covariance += Mat2::from_cols(side * side.x, side * side.y);
            }
            let wider = covariance + Mat2::from_diagonal(Vec2::splat(0.3));
            let share = (covariance.determinant().max(0.0) / wider.determinant()).sqrt();
            let off = Vec2::from(axes.map(|to| to.dot(splat.center))) - at;
            let density = (-0.5 * off.dot(wider.inverse() * off)).exp();
            1.0 - (splat.opacity * density * if is_antialiased { share } else { 1.0 }).min(0.99)
        });
        left.product()
    }

    #[test]
    fn a_flat_wall_is_opaque_from_half_a_pixel_to_four_for_each_of_its_samples_face_on_and_at_a_slant() {
        let wall = wall();
        let [across, down, out] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| wall[0].rotation * axis);
        for pixels in [0.5, 1.0, 2.0, 4.0] {
            for slant in [0.0_f32, 45.0, 70.0] {
                let (sin, cos) = slant.to_radians().sin_cos();
                let axes = [across, down * cos + out * sin].map(|axis| axis * pixels);
                for place in 0..64 {
                    let at = Vec2::new((place % 8) as f32, (place / 8) as f32 * cos) * (pixels / 4.0);
                    for is_antialiased in [false, true] {
                        let shown = shown_behind(&wall, axes, at, is_antialiased);
                        assert!(shown < 0.04, "{pixels} {slant} {is_antialiased}: {shown}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_back_lies_in_the_midst_of_an_even_surface_and_nowhere_else() {
        let plane: [f32; 16] =
            std::array::from_fn(|at| 1.0 + 0.01 * (at % 4) as f32 - 0.02 * (at / 4) as f32);
        assert!(is_inside(&plane, 1e-3));
        let but = |lines: &[usize], depth: f32| {
            let mut around = plane;
            for at in lines {
                around[*at] = depth;
            }
            is_inside(&around, 1e-3)
        };
        assert!(!but(&[3, 7, 11, 15], 0.5) && !but(&[0], 0.5), "it ends there");
        assert!(
            but(&[3, 7, 11, 15], 0.0) && !but(&[0, 1, 2, 3, 4, 8, 12], 0.0),
            "another camera's samples may be there"
        );
        assert!(!but(&[5], 0.0));
    }
}
