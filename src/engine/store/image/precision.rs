//! Rounding of samples where the precision is not lossless, and the check that the error stays within it.
//!
//! Color is held to half a step of a display with that many bits, by the choice of the [palette](super::color_ranks). Inverse depth
//! is rounded by leaving off its lowest bits: the relative error of `w` is that of `z`, and a pixel's footprint at depth `z` is
//! `z / f` across, so that an error of `p` footprints is a relative error of `p / f`, whatever the depth.

use super::blocks::LARGEST_DEPTH;
use super::color_ranks::{ColorRanks, half_step};
use crate::capture::Camera;
use crate::color::steps_from_linear;
use crate::samples::{DepthPlane, SampleImage};
use crate::settings::{Precision, StoreSettings};

/// The largest error of color that the settings grant, in 8-bit display steps; 0 for none.
fn color_error(settings: &StoreSettings) -> f32 {
    match settings.precision {
        Precision::Lossless => 0.0,
        Precision::Bits16 => half_step(16),
        Precision::Bits12 => half_step(12),
        Precision::Bits10 => half_step(10),
        Precision::Bits8 => half_step(8),
    }
}

/// How far colors that were held to `before` may be moved, in 8-bit display steps, and still be held to `settings`; 0 where they
/// may not be moved.
pub(crate) fn color_room(settings: &StoreSettings, before: Option<&StoreSettings>) -> f32 {
    (color_error(settings) - before.map_or(0.0, color_error)).max(0.0)
}

/// Whether samples that were held to `before` can be held to `settings`: what was left out is not known any more.
pub(crate) fn check_again(
    settings: &StoreSettings,
    before: &StoreSettings,
    cameras: &[Camera],
) -> Result<(), String> {
    let what = settings.precision;
    if before.precision == Precision::Lossless {
        return Ok(());
    }
    if color_error(settings) < color_error(before) {
        return Err(format!("cannot be {what} any more: the store has a precision of {}", before.precision));
    }
    let errs = |camera: &Camera| {
        let (now, earlier) = (depth_shift(camera, settings), depth_shift(camera, before));
        let rounding = |shift: u32| if shift == 0 { 0.0 } else { f64::from(1_u32 << (shift - 1)) };
        // What was rounded before may err by all that was granted, by however many roundings; the same bits are left off but once.
        let further = if now == earlier { 0.0 } else { rounding(now) };
        further + depth_error(camera, before) * UNITS > depth_error(camera, settings) * UNITS
    };
    if cameras.iter().any(errs) {
        let (now, earlier) = (settings.depth_precision, before.depth_precision);
        return Err(format!(
            "cannot hold depth to {now} footprints: the store has held it to {earlier}; keep that, or preprocess the capture again"
        ));
    }
    Ok(())
}

/// The relative error of inverse depth that the settings grant for a camera: none for an orthographic one, where so many footprints are
/// another share of every depth.
fn depth_error(camera: &Camera, settings: &StoreSettings) -> f64 {
    if camera.intrinsics.is_orthographic() {
        return 0.0;
    }
    f64::from(settings.depth_precision) / camera.intrinsics.fx.max(camera.intrinsics.fy)
}

/// Lowest bits of a float's fraction in a relative error of 1, at least.
const UNITS: f64 = (1 << 23) as f64;

/// Lowest bits of inverse depth that may be left off: 2^(shift − 1) in the 24 bits of a float's fraction is the error.
pub(crate) fn depth_shift(camera: &Camera, settings: &StoreSettings) -> u32 {
    if settings.precision == Precision::Lossless {
        return 0;
    }
    let units = depth_error(camera, settings) * UNITS;
    (0..=16).rev().find(|shift| *shift == 0 || f64::from(1 << (shift - 1)) <= units).unwrap_or(0)
}

/// The image as the store will hold it: colors by the palette, which may move them by `color_room`.
///
/// # Errors
/// Where a sample would err by more than the settings grant: that would be a defect of this program.
pub(crate) fn reduce(
    image: &SampleImage,
    camera: &Camera,
    palette: &ColorRanks,
    color_room: f32,
    settings: &StoreSettings,
) -> Result<SampleImage, String> {
    let shift = depth_shift(camera, settings);
    let half = if shift == 0 { 0 } else { 1_u32 << (shift - 1) };
    let before = image.inverse_depths();
    let after: Vec<f32> = before
        .iter()
        .map(|depth| {
            f32::from_bits(depth.to_bits().saturating_add(half).min(LARGEST_DEPTH) >> shift << shift)
        })
        .collect();
    let color = image.color.iter().map(|color| color.map(|half| palette.color(palette.rank(half))));
    let color: Option<Vec<_>> = color.map(|[red, green, blue]| Some([red?, green?, blue?])).collect();
    let color = color.ok_or("a color is not in the palette")?;
    let reduced = SampleImage { color, depth: DepthPlane::pack(&image.tiles, &after), ..image.clone() };

    let allowed = depth_error(camera, settings);
    let far = |a: &f32, b: &f32| (f64::from(*a) - f64::from(*b)).abs() > allowed * f64::from(*a);
    // Below the smallest normal float there is no relative precision to hold: such a depth is infinity to any camera.
    if before.iter().zip(&after).any(|(a, b)| far(a, b) && *a >= f32::MIN_POSITIVE) {
        return Err("an inverse depth errs by more than the precision that is set".to_owned());
    }
    let mut pairs = image.color.iter().flatten().zip(reduced.color.iter().flatten());
    if pairs.any(|(a, b)| (steps_from_linear(*a) - steps_from_linear(*b)).abs() > color_room) {
        return Err("a color errs by more than the precision that is set".to_owned());
    }
    Ok(reduced)
}
