//! What goes into a renderer and what comes out.

use rayon::prelude::*;

use super::stage_times::StageTimes;
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::samples::SampleSet;

/// From where and when a picture is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Vantage {
    /// The virtual camera.
    pub camera: Camera,
    /// Index of the frame.
    pub frame: usize,
}

impl Vantage {
    /// Checks that a picture of these samples can be rendered: a frame that exists, between 1 and [`MAX_PIXELS`] pixels, finite
    /// numbers, focal lengths above 0, and a pose that has an inverse.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the vantage and the part of it that is wrong.
    pub fn check(&self, samples: &SampleSet) -> Result<()> {
        let refuse = |what: String| Err(Error::invalid(format!("viewpoint '{}'", self.camera.name), what));
        let k = self.camera.intrinsics;
        if ![k.fx, k.fy].iter().all(|focal| focal.is_finite() && *focal > 0.0) {
            return refuse(
                "its focal lengths must be finite and above 0; give fx and fy in pixels".to_owned(),
            );
        }
        if !(k.cx.is_finite() && k.cy.is_finite()) {
            return refuse("its principal point is not finite; give cx and cy in pixels".to_owned());
        }
        let pose = self.camera.world_from_camera;
        if !pose.is_finite() {
            return refuse("its pose holds numbers that are not finite; place the camera anew".to_owned());
        }
        if pose.matrix3.determinant().abs() < SMALLEST_DETERMINANT {
            return refuse("its pose is flat: the axes must be at right angles and of length 1".to_owned());
        }
        let (width, height) = k.size();
        if !(1..=MAX_PIXELS).contains(&width.saturating_mul(height)) {
            return refuse(format!(
                "a picture of {width}×{height} pixels cannot be rendered; choose between 1 and {MAX_PIXELS} pixels"
            ));
        }
        let frames = samples.frame_count();
        if self.frame >= frames {
            return refuse(format!("there is no frame {}; '{}' has {frames}", self.frame, samples.name));
        }
        Ok(())
    }
}

/// Largest picture that is rendered, pixels: 16K by 8K.
pub const MAX_PIXELS: usize = 1 << 27;

/// A rotation has determinant 1; below this the inverse pose is numerical noise.
const SMALLEST_DETERMINANT: f64 = 1e-6;

/// Marks a pixel that no sample reached, in [`Picture::image`].
pub const NO_IMAGE: u32 = u32::MAX;

/// A rendered vantage.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Linear Rec.709; black in holes that were not filled.
    pub color: Grid<[f32; 3]>,
    /// Reciprocal of planar z of the nearest sample; 0 at infinity, negative in holes that were not filled.
    pub inverse_depth: Grid<f32>,
    /// Index in `SampleSet::images` of the image whose sample is nearest; [`NO_IMAGE`] in holes, filled or not.
    pub image: Grid<u32>,
    /// For pixels that show more than one surface: what they show without the farthest one. Negative inverse depths elsewhere; empty
    /// unless lines of sight are to be tested.
    pub fronts: Vec<FrontColor>,
    /// Share of each pixel that is shown, 0 to 1, row-major; `color` is that of the shown part, in pixels that count as holes as well.
    /// Empty where pixels are shown all or not at all, and where holes are filled.
    pub coverage: Vec<f32>,
}

/// Red, green and blue of what a pixel shows in front of its farthest surface, linear Rec.709, the inverse depth of that one, and the
/// share of the pixel that lies in front, 0 to 1.
pub(crate) type FrontColor = [f32; 5];

/// The front of a pixel that shows one surface.
pub(crate) const NO_FRONT: FrontColor = [0.0, 0.0, 0.0, -1.0, 0.0];

/// A pixel shows samples from this share on that they cover; with less it is a hole.
pub(crate) const LEAST_SHOWN: f32 = 0.5;

/// The pixels around one of a picture of a size, itself among them, as far as they are in the picture: indices, row-major.
#[inline(always)]
pub(crate) fn pixels_around(pixel: usize, (width, height): (usize, usize)) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    rows.flat_map(move |y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| y * width + x))
}

impl Picture {
    /// A picture of holes.
    #[must_use]
    pub fn empty(width: usize, height: usize) -> Self {
        Self {
            color: Grid::filled(width, height, [0.0; 3]),
            inverse_depth: Grid::filled(width, height, -1.0),
            image: Grid::filled(width, height, NO_IMAGE),
            fronts: Vec::new(),
            coverage: Vec::new(),
        }
    }

    /// Share of a pixel that shows a sample or the filling of a hole, 0 to 1.
    #[must_use]
    pub fn alpha(&self, pixel: (usize, usize)) -> f32 {
        let all_or_nothing = || f32::from(u8::from(self.shows(pixel)));
        let share = self.coverage.get(pixel.1 * self.image.width() + pixel.0);
        share.copied().unwrap_or_else(all_or_nothing)
    }

    /// Whether a pixel shows anything: a sample or the filling of a hole.
    #[must_use]
    pub fn shows(&self, pixel: (usize, usize)) -> bool {
        self.image[pixel] != NO_IMAGE || self.inverse_depth[pixel] >= 0.0
    }

    /// Pixels that no sample reached, filled or not.
    #[must_use]
    pub fn holes(&self) -> u64 {
        let holes_in = |part: &[u32]| part.iter().map(|image| u32::from(*image == NO_IMAGE)).sum::<u32>();
        self.image.as_slice().par_chunks(1 << 16).map(|part| u64::from(holes_in(part))).sum()
    }
}

/// The cost of rendering a vantage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Samples that were projected, each counted once however often the picture is rendered for its edges or levels.
    pub samples: u64,
    /// Pixels that no sample reached, filled or not.
    pub holes: u64,
    /// Wall-clock milliseconds, filling included.
    pub milliseconds: f64,
    /// The milliseconds of each stage; zeros where the graphics adapter does not tell.
    pub stages: StageTimes,
    /// Whether the background was taken from the cache instead of being painted.
    pub background_reused: bool,
}
