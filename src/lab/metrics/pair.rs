//! A picture beside its truth, and all metrics of the two.

use rayon::prelude::*;

use super::error_class::near_silhouettes;
use super::flip::{DEFAULT_PIXELS_PER_DEGREE, flip};
use super::psnr::{MAX_PSNR_DB, mean_squared_error, psnr_db};
use super::ssim::{ms_ssim, ssim};
use overlook_engine::capture::Frame;
use overlook_engine::color::srgb_from_linear;
use overlook_engine::error::{Error, Result};
use overlook_engine::grid::Grid;
use overlook_engine::render::{NO_IMAGE, Picture};

/// How close one picture is to the truth.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Scores {
    /// Peak signal-to-noise ratio over the true pixels that got a sample, dB; read it together with `coverage`. Where no
    /// pixel got one, the same as `psnr_all_db`. Filling holes changes it only where pictures are supersampled: a pixel that is
    /// partly a hole then shows its filling too.
    pub psnr_db: f64,
    /// PSNR over all true pixels, dB. Holes count as black or as what fills them, so that this number shows the effect of
    /// filling. Sky that no camera saw weighs heavily in it.
    pub psnr_all_db: f64,
    /// Structural similarity of luma, -1 to 1, over windows whose middle got a sample; 0 where none did. Such windows reach
    /// into holes, which are black or filled as the settings say.
    pub ssim: f64,
    /// The same over several scales, 0 to 1.
    pub ms_ssim: f64,
    /// Mean FLIP difference, 0 (none) to 1, over the true pixels that got a sample; 0 where none did. Its filters reach into
    /// holes as SSIM's windows do.
    pub flip: f64,
    /// Root mean square error of the true pixels within 3 px of a step in depth, holes included, 8-bit steps; `None` where
    /// nothing has a silhouette. Holes count as in `psnr_all_db`.
    pub silhouette_steps: Option<f64>,
    /// Share of the true pixels (those with a depth or at infinity) that got a sample, 0 to 1; 1 where there are none.
    /// A filled hole got none.
    pub coverage: f64,
}

/// A picture beside its truth, as a display shows both.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    painted_linear: Grid<[f32; 3]>,
    true_linear: Grid<[f32; 3]>,
    painted: Vec<[f32; 3]>,
    truth: Vec<[f32; 3]>,
    /// Whether the true pixel is known.
    is_true: Vec<bool>,
    /// Whether the true pixel is known and got a sample.
    is_reached: Grid<bool>,
    near_silhouettes: Grid<bool>,
}

impl Pair {
    /// Puts a picture beside its truth.
    pub(crate) fn new(picture: &Picture, truth: &Frame) -> Result<Self> {
        let (width, height) = picture.color.size();
        if (width, height) != truth.size() {
            let (true_width, true_height) = truth.size();
            return Err(Error::invalid(
                "truth",
                format!(
                    "the true picture is {true_width}×{true_height} but the viewpoint is {width}×{height}"
                ),
            ));
        }
        let is_true: Vec<bool> = truth.inverse_depth.as_slice().iter().map(|depth| *depth >= 0.0).collect();
        let true_linear = truth.color.map(|color| color.map(half::f16::to_f32));
        let mut painted_linear = picture.color.clone();
        for (pixel, painted) in painted_linear.as_mut_slice().iter_mut().enumerate() {
            if !is_true[pixel] {
                *painted = true_linear.as_slice()[pixel];
            }
        }
        let reached = picture.image.as_slice().iter().zip(&is_true);
        let is_reached = reached.map(|(image, is_true)| *is_true && *image != NO_IMAGE).collect();
        Ok(Self {
            painted: display_values(painted_linear.as_slice()),
            truth: display_values(true_linear.as_slice()),
            is_reached: Grid::from_vec(width, height, is_reached),
            near_silhouettes: near_silhouettes(&truth.inverse_depth),
            painted_linear,
            true_linear,
            is_true,
        })
    }

    /// Whether any pixel of the truth is known; otherwise the scores mean nothing.
    pub(crate) fn has_truth(&self) -> bool {
        self.is_true.contains(&true)
    }

    /// All metrics of a single picture.
    pub(crate) fn scores(&self) -> Scores {
        let is_reached = self.is_reached.as_slice();
        let all = || (0..self.painted.len()).filter(|&pixel| self.is_true[pixel]);
        let reached = || (0..self.painted.len()).filter(|&pixel| is_reached[pixel]);
        let near = all().filter(|&pixel| self.near_silhouettes.as_slice()[pixel]);
        let psnr_all_db = psnr_db(&self.painted, &self.truth, all()).unwrap_or(MAX_PSNR_DB);
        let (painted_luma, true_luma) = (self.luma_of(&self.painted), self.luma_of(&self.truth));
        let (reached_count, true_count) = (reached().count(), all().count());
        let flip = flip(&self.painted_linear, &self.true_linear, DEFAULT_PIXELS_PER_DEGREE);
        let flip_sum: f64 = reached().map(|pixel| f64::from(flip.as_slice()[pixel])).sum();
        Scores {
            psnr_db: psnr_db(&self.painted, &self.truth, reached()).unwrap_or(psnr_all_db),
            psnr_all_db,
            ssim: ssim(&painted_luma, &true_luma, |x, y| self.is_reached[(x, y)]),
            ms_ssim: ms_ssim(&painted_luma, &true_luma, &self.is_reached),
            flip: flip_sum / reached_count.max(1) as f64,
            silhouette_steps: mean_squared_error(&self.painted, &self.truth, near)
                .map(|error| 255.0 * error.sqrt()),
            coverage: if true_count == 0 { 1.0 } else { reached_count as f64 / true_count as f64 },
        }
    }

    /// Error per channel of what is displayed, -1 to 1; `None` without a sample or truth.
    pub(super) fn errors(&self) -> Vec<Option<[f32; 3]>> {
        let pairs = self.painted.iter().zip(&self.truth).zip(self.is_reached.as_slice());
        pairs
            .map(|((painted, truth), is_reached)| {
                is_reached.then(|| std::array::from_fn(|channel| painted[channel] - truth[channel]))
            })
            .collect()
    }

    fn luma_of(&self, values: &[[f32; 3]]) -> Grid<f32> {
        let (width, height) = self.is_reached.size();
        Grid::from_vec(width, height, values.iter().map(luma).collect())
    }
}

/// Compares a picture with the truth.
///
/// # Errors
/// [`Error::Invalid`] where the two differ in size.
pub fn score(picture: &Picture, truth: &Frame) -> Result<Scores> {
    Ok(Pair::new(picture, truth)?.scores())
}

/// Linear Rec.709 as a display shows it: sRGB-encoded and clipped to 0 to 1.
fn display_values(linear: &[[f32; 3]]) -> Vec<[f32; 3]> {
    linear.par_iter().map(|color| color.map(|value| srgb_from_linear(value).clamp(0.0, 1.0))).collect()
}

/// Luma of an encoded color (0 to 1), 8-bit scale: 0 to 255. The weights are Rec.601's, as in the SSIM authors' code.
#[must_use]
pub fn luma(encoded: &[f32; 3]) -> f32 {
    255.0 * (0.299 * encoded[0] + 0.587 * encoded[1] + 0.114 * encoded[2])
}

#[cfg(test)]
mod tests {
    use super::super::flicker::FlickerMeter;
    use super::*;
    use overlook_engine::capture::{Camera, Intrinsics};

    fn white_picture() -> (Picture, Frame) {
        let picture = Picture {
            color: Grid::filled(4, 1, [1.0; 3]),
            inverse_depth: Grid::filled(4, 1, 0.5),
            image: Grid::filled(4, 1, 0),
            ..Picture::empty(0, 0)
        };
        let truth = Frame {
            color: Grid::filled(4, 1, [half::f16::ONE; 3]),
            inverse_depth: Grid::from_vec(4, 1, vec![0.5, 0.0, 0.5, -1.0]),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: overlook_engine::capture::Values::default(),
        };
        (picture, truth)
    }

    #[test]
    fn holes_count_as_black_and_against_coverage_but_only_where_there_is_truth() {
        let (mut picture, truth) = white_picture();
        assert_eq!(score(&picture, &truth).unwrap().coverage, 1.0);
        for hole in [1, 3] {
            picture.color[(hole, 0)] = [0.0; 3];
            picture.image[(hole, 0)] = NO_IMAGE;
        }
        let scores = score(&picture, &truth).unwrap();
        assert!((scores.coverage - 2.0 / 3.0).abs() < 1e-12);
        assert!((scores.psnr_all_db - 10.0 * 3.0_f64.log10()).abs() < 1e-5);
        assert_eq!(scores.psnr_db, MAX_PSNR_DB);
        picture.color = Grid::filled(2, 2, [0.0; 3]);
        assert!(score(&picture, &truth).is_err());
    }

    #[test]
    fn what_the_truth_does_not_know_changes_no_score() {
        let (picture, truth) = white_picture();
        let mut other = picture.clone();
        other.color[(3, 0)] = [0.0, 0.5, 0.0];
        assert_eq!(score(&picture, &truth).unwrap(), score(&other, &truth).unwrap());
    }

    #[test]
    fn a_constant_error_does_not_flicker_and_one_that_comes_and_goes_does() {
        let (picture, truth) = white_picture();
        let camera = |name| {
            Camera::look_at(
                name,
                Intrinsics::from_horizontal_angle(4, 1, 1.0),
                glam::DVec3::ZERO,
                glam::DVec3::Y,
                glam::DVec3::Z,
            )
        };
        let mut dark = picture.clone();
        dark.color = Grid::filled(4, 1, [overlook_engine::color::linear_from_srgb(0.9); 3]);
        let [bright, dark] = [picture, dark].map(|picture| Pair::new(&picture, &truth).unwrap());
        let flicker = |views: &[(&Camera, &Pair)]| {
            let mut meter = FlickerMeter::default();
            for (camera, pair) in views {
                meter.add(camera, pair);
            }
            meter.steps()
        };
        let (one, two) = (camera("one"), camera("two"));
        assert_eq!(flicker(&[(&one, &dark), (&two, &bright)]), None);
        assert_eq!(flicker(&[(&one, &dark), (&one, &dark)]), Some(0.0));
        let steps = flicker(&[(&one, &dark), (&one, &bright), (&two, &dark)]).unwrap();
        assert!((steps - 25.5).abs() < 0.01, "{steps}");
    }
}
