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
}
