//! How much the color of a surface depends on where it is seen from: highlights, mirrors, and exposures that differ.
//!
//! Purpose: methods that put recorded pixels on surfaces are exact where surfaces look the same from everywhere. Where they do not,
//! a picture is wrong between cameras, however dense these are, and no threshold mends it. This shows where.
//!
//! Source: the residual beside a color that is the same in all directions, as it decides where a light field needs more (D. N.
//! Wood et al., *Surface Light Fields for 3D Photography*, SIGGRAPH 2000, §4). What differs: cameras that are a fraction of a pixel off
//! each other must not count as a difference, so that a color is compared with the range of the 3×3 pixels around its place in the
//! other camera. What noise explains is left out.

use rayon::prelude::*;

use super::frame::FrameInspection;
use crate::capture::overlap::OverlapGraph;
use crate::color::steps_from_linear;
use crate::grid::Grid;
use crate::preprocess::layers::{CameraLayer, is_mixed};
use crate::preprocess::registration::{Outcome, SameSurface};
use crate::simd::root_of_squares;

/// A color depends on the view if two cameras see it differently by at least this many 8-bit sRGB steps.
pub const VISIBLE_STEPS: f32 = 8.0;

/// Only pixels whose areas on the surface differ by at most this factor show equally much of a texture.
const ALIKE: f32 = 4.0;

/// What is beside a pixel is of the same surface while inverse depths differ by no more than this share.
const ONE_SURFACE: f32 = 0.05;

/// Differences of less than this many standard deviations are noise.
const SIGMAS: f32 = 3.0;

impl FrameInspection {
    /// By how much the color of each pixel of `camera` differs from what the other cameras show of the same surface point, whatever
    /// the thresholds of color are: the root of the mean square over these cameras, in 8-bit sRGB steps of the channel where it is
    /// most. NaN where no other camera shows the point about as finely, beside steps in depth, where colors may be blended, and without
    /// depth. It is worked out at each call.
    #[must_use]
    pub fn view_dependence(&self, camera: usize) -> Grid<f32> {
        if self.is_of_store() {
            return self.unknown(camera, f32::NAN);
        }
        let pairs = OverlapGraph::complete(&self.samples.cameras);
        let limits = SameSurface::geometry_of(&self.settings);
        let layer = &self.layers[camera];
        let (width, height) = (layer.width, layer.height());
        let values = (0..width * height).into_par_iter().map(|pixel| {
            if layer.inverse_depth[pixel] < 0.0 || is_beside_step(layer, pixel) {
                return f32::NAN;
            }
            let (mut squares, mut count) = (0.0, 0.0_f32);
            for (other, target) in self.layers.iter().enumerate().filter(|(other, _)| *other != camera) {
                let registration = pairs.registration(camera, other);
                let (x, y) = (pixel % width, pixel / width);
                let Outcome::Same(found) = limits.test(registration, layer, x, y, target) else { continue };
                let coarser = target.footprint[found as usize] / layer.footprint[pixel];
                if (ALIKE.recip()..=ALIKE).contains(&coarser) {
                    squares += difference(layer, pixel, target, found as usize).powi(2);
                    count += 1.0;
                }
            }
            (squares / count).sqrt()
        });
        Grid::from_vec(width, height, values.collect())
    }
}

/// The 3×3 pixels around one, itself among them, as far as they are in the picture.
fn around(layer: &CameraLayer, pixel: usize) -> impl Iterator<Item = usize> {
    let (x, y, width) = (pixel % layer.width, pixel / layer.width, layer.width);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    let rows = y.saturating_sub(1)..(y + 2).min(layer.height());
    rows.flat_map(move |y| columns.clone().map(move |x| y * width + x))
}

/// Whether a pixel is known to be blended, or another surface is beside it.
fn is_beside_step(layer: &CameraLayer, pixel: usize) -> bool {
    let own = layer.inverse_depth[pixel];
    let is_other = |at: usize| (layer.inverse_depth[at] - own).abs() > ONE_SURFACE * own;
    is_mixed(layer.ranks[pixel]) || around(layer, pixel).any(is_other)
}

/// By how many 8-bit sRGB steps a color is outside the range of the 3×3 pixels around one of another camera, beyond what noise
/// explains: of the channel where that is most.
fn difference(layer: &CameraLayer, pixel: usize, target: &CameraLayer, found: usize) -> f32 {
    let own = layer.color[pixel].map(steps_from_linear);
    let mut range = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for at in around(target, found).filter(|at| target.inverse_depth[*at] >= 0.0) {
        let seen = target.color[at].map(steps_from_linear);
        for channel in 0..3 {
            range[0][channel] = range[0][channel].min(seen[channel]);
            range[1][channel] = range[1][channel].max(seen[channel]);
        }
    }
    let beyond = |channel: usize| {
        let [low, high] = range.map(|bound| bound[channel]);
        let nearest = own[channel].clamp(low, high);
        let over_time =
            root_of_squares(layer.color_noise(pixel, own[channel]), target.color_noise(found, nearest));
        let between =
            root_of_squares(layer.color_noise_between(own[channel]), target.color_noise_between(nearest));
        ((own[channel] - nearest).abs() - SIGMAS * over_time.max(between)).max(0.0)
    };
    (0..3).map(beyond).fold(0.0, f32::max)
}
