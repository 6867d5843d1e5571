//! The error of a picture by class: on surfaces that no camera saw, at silhouettes, or elsewhere.
//!
//! Purpose: the three have different causes (filling, antialiasing, interpolation), which a mean over the picture hides.
//!
//! Which pixel belongs to which class is decided by the truth alone, so that all methods are measured by the same pixels.

use serde::{Deserialize, Serialize};

use super::psnr::MAX_PSNR_DB;
use overlook_engine::capture::Frame;
use overlook_engine::color::srgb_from_linear;
use overlook_engine::grid::Grid;
use overlook_engine::render::Picture;

/// What a true pixel that shows a surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorClass {
    /// No camera saw its surface point.
    Unseen,
    /// Seen, within 2 px of a step in the true depth.
    Edge,
    /// All others.
    Inner,
}

impl ErrorClass {
    /// Its color in maps of errors, sRGB: pink, orange or blue, which color-blind people can distinguish.
    #[must_use]
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::Unseen => [224, 132, 184],
            Self::Edge => [230, 159, 0],
            Self::Inner => [86, 180, 233],
        }
    }
}

/// The class of every pixel; `None` where the truth shows no surface.
pub type ClassMap = Grid<Option<ErrorClass>>;

/// The error of one class of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClassScore {
    /// Share of the pixels that show a surface, 0 to 1.
    pub share: f64,
    /// PSNR over these pixels, holes as they are shown; `None` where there are none.
    pub psnr_db: Option<f64>,
    /// Share of the squared error of all pixels that show a surface, 0 to 1.
    pub of_error: f64,
}

/// The error of all classes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorByClass {
    /// See [`ErrorClass::Unseen`].
    pub unseen: ClassScore,
    /// See [`ErrorClass::Edge`].
    pub edge: ClassScore,
    /// See [`ErrorClass::Inner`].
    pub inner: ClassScore,
}

/// Number of pixels and sum of squared errors of each class, over any number of pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ClassErrors([(u64, f64); 3]);

impl ClassErrors {
    /// Compares a picture with its truth; all three of one size.
    pub(crate) fn of(picture: &Picture, truth: &Frame, classes: &ClassMap) -> Self {
        let mut sums = Self::default();
        let pixels = picture.color.as_slice().iter().zip(truth.color.as_slice()).zip(classes.as_slice());
        for ((painted, true_color), class) in pixels {
            let Some(class) = class else { continue };
            let displayed = |linear: f32| f64::from(srgb_from_linear(linear).clamp(0.0, 1.0));
            let of_channel = |(painted, truth): (&f32, &half::f16)| {
                (displayed(*painted) - displayed(truth.to_f32())).powi(2)
            };
            let (count, sum) = &mut sums.0[*class as usize];
            *count += 1;
            *sum += painted.iter().zip(true_color).map(of_channel).sum::<f64>() / 3.0;
        }
        sums
    }

    /// Adds those of other pictures.
    pub(crate) fn add(&mut self, other: &Self) {
        for ((count, sum), (more, further)) in self.0.iter_mut().zip(other.0) {
            *count += more;
            *sum += further;
        }
    }

    /// Shares and PSNR of each class; `None` where no pixel shows a surface.
    pub(crate) fn scores(&self) -> Option<ErrorByClass> {
        let pixels: u64 = self.0.iter().map(|(count, _)| count).sum();
        let error: f64 = self.0.iter().map(|(_, sum)| sum).sum();
        let score = |class: ErrorClass| {
            let (count, sum) = self.0[class as usize];
            ClassScore {
                share: count as f64 / pixels as f64,
                psnr_db: (count > 0).then(|| (-10.0 * (sum / count as f64).log10()).min(MAX_PSNR_DB)),
                of_error: if error > 0.0 { sum / error } else { 0.0 },
            }
        };
        (pixels > 0).then(|| ErrorByClass {
            unseen: score(ErrorClass::Unseen),
            edge: score(ErrorClass::Edge),
            inner: score(ErrorClass::Inner),
        })
    }
}

/// Farthest distance of a silhouette pixel from a step in depth, pixels.
pub(super) const REACH_PX: f64 = 3.0;

/// A step is a second difference of inverse depth, which vanishes on every plane, of this share of the nearest depth
/// involved. A crease that turns by 90° where a surface is 1000 pixels away gives a tenth of it.
const STEP_RELATIVE: f32 = 0.02;

/// The pixels within [`REACH_PX`] of a step in depth, given inverse depths (0 at infinity, negative where unknown;
/// next to the unknown nothing is a step).
pub(super) fn near_silhouettes(inverse_depth: &Grid<f32>) -> Grid<bool> {
    let (width, height) = inverse_depth.size();
    let reach = REACH_PX as usize;
    let mut near = Grid::filled(width, height, false);
    for y in 0..height {
        for x in 0..width {
            if !is_step(inverse_depth, x, y) {
                continue;
            }
            for ny in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                for nx in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                    let distance = (nx as f64 - x as f64).hypot(ny as f64 - y as f64);
                    near[(nx, ny)] |= distance <= REACH_PX;
                }
            }
        }
    }
    near
}

fn is_step(inverse_depth: &Grid<f32>, x: usize, y: usize) -> bool {
    let (width, height) = inverse_depth.size();
    let middle = inverse_depth[(x, y)];
    let steps = |before: f32, after: f32| {
        let nearest = before.max(middle).max(after);
        before.min(middle).min(after) >= 0.0
            && (before - 2.0 * middle + after).abs() > STEP_RELATIVE * nearest
    };
    let across = x > 0 && x + 1 < width && steps(inverse_depth[(x - 1, y)], inverse_depth[(x + 1, y)]);
    let down = y > 0 && y + 1 < height && steps(inverse_depth[(x, y - 1)], inverse_depth[(x, y + 1)]);
    across || down
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::color::linear_from_srgb;

    #[test]
    fn each_class_has_its_share_of_the_error_and_pixels_without_a_surface_have_none() {
        let picture =
            Picture { color: Grid::filled(4, 1, [linear_from_srgb(0.5); 3]), ..Picture::empty(4, 1) };
        let gray = |encoded: f32| [half::f16::from_f32(linear_from_srgb(encoded)); 3];
        let truth = Frame {
            color: Grid::from_vec(4, 1, vec![gray(0.5), gray(0.6), gray(0.8), gray(0.0)]),
            inverse_depth: Grid::filled(4, 1, 1.0),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: overlook_engine::capture::Values::default(),
        };
        let classes = [Some(ErrorClass::Inner), Some(ErrorClass::Edge), Some(ErrorClass::Unseen), None];
        let mut errors = ClassErrors::of(&picture, &truth, &Grid::from_vec(4, 1, classes.to_vec()));
        let alone = errors.scores().unwrap();
        assert!((alone.edge.of_error - 0.1).abs() < 1e-3 && (alone.unseen.of_error - 0.9).abs() < 1e-3);
        assert!((alone.edge.psnr_db.unwrap() - 20.0).abs() < 0.02, "{alone:?}");
        assert!(alone.inner.psnr_db.unwrap() > 60.0);
        let again = errors;
        errors.add(&again);
        assert_eq!(errors.scores().unwrap(), alone, "twice the pixels with twice the error");
        assert_eq!(ClassErrors::default().scores(), None);
    }

    #[test]
    fn a_plane_has_no_silhouette_however_steep_and_a_step_has_one_three_pixels_wide() {
        let plane = Grid::from_fn(20, 20, |x, y| 0.01 + 0.05 * x as f32 + 0.02 * y as f32);
        assert!(near_silhouettes(&plane).as_slice().iter().all(|near| !near));
        let step = Grid::from_fn(20, 9, |x, _| if x < 10 { 1.0 } else { 0.5 });
        let near = near_silhouettes(&step);
        for y in 0..9 {
            for x in 0..20 {
                assert_eq!(near[(x, y)], (6..=13).contains(&x), "{x} {y}");
            }
        }
    }

    #[test]
    fn an_object_before_the_sky_has_a_silhouette_and_unknown_depth_has_none() {
        let sky = Grid::from_fn(9, 9, |x, _| if x < 4 { 0.3 } else { 0.0 });
        assert!(near_silhouettes(&sky)[(4, 4)]);
        let unknown = Grid::from_fn(9, 9, |x, _| if x < 4 { 0.3 } else { -1.0 });
        assert!(near_silhouettes(&unknown).as_slice().iter().all(|near| !near));
    }
}
