//! Colors that differ by more than the tolerance, but by no more than the noise of both cameras explains.

use super::answers::{COLOR_AGREES, RequiredTolerances, SAME, SURROUNDED, SurfaceMatches};
use super::reproject::PixelRun;
use crate::preprocess::layers::{COLOR_STEPS, CameraLayer, PackedColor};

/// All that has to hold before the color of a sample matters.
const BUT_LOOKS: u32 = SAME & !(COLOR_AGREES | SURROUNDED);

/// The color tolerance that each sample needs once noise is granted.
#[cold]
#[inline(never)]
pub(crate) fn require_beyond_noise<const N: usize>(
    (source, block): (&CameraLayer, &PixelRun<N>),
    (target, packed_colors): (&CameraLayer, &[PackedColor; N]),
    answers: &SurfaceMatches<N>,
    sigmas: f32,
    required: &mut RequiredTolerances<N>,
) {
    for (i, packed) in packed_colors.iter().enumerate() {
        if answers.bits[i] & BUT_LOOKS != BUT_LOOKS || required.color[i] <= required.negligible_steps {
            continue;
        }
        let beyond = beyond_noise((source, block, i), (target, answers.pixel[i], packed), sigmas);
        required.color[i] = required.color[i].min(beyond);
    }
}

/// By how many 8-bit steps the color of a block's sample differs from one of the target beyond what the noise of both explains: of
/// the channel where that is most.
#[inline(always)]
fn beyond_noise<const N: usize>(
    (source, block, lane): (&CameraLayer, &PixelRun<N>, usize),
    (target, found, packed): (&CameraLayer, u32, &PackedColor),
    sigmas: f32,
) -> f32 {
    let pixel = block.row * source.width + block.column + lane;
    let found_color = packed.color();
    let of_channel = |channel: usize| {
        let [a, b] =
            [block.color[channel][lane], found_color[channel]].map(|color| color as f32 / COLOR_STEPS);
        let noise = source.color_noise(pixel, a).hypot(target.color_noise(found as usize, b));
        (a - b).abs() - sigmas * noise
    };
    of_channel(0).max(of_channel(1)).max(of_channel(2))
}

/// Looks again at colors that differ by more than the tolerance: the measured noise of both may explain it.
#[cold]
#[inline(never)]
pub(crate) fn allow_noise<const N: usize>(
    (source, block): (&CameraLayer, &PixelRun<N>),
    (target, packed_colors): (&CameraLayer, &[PackedColor; N]),
    answers: &mut SurfaceMatches<N>,
    (color_steps, sigmas): (f32, f32),
    relevant: [u32; N],
) {
    for (i, packed) in packed_colors.iter().enumerate() {
        if relevant[i] == 0 || answers.bits[i] & (BUT_LOOKS | COLOR_AGREES) != BUT_LOOKS {
            continue;
        }
        let beyond = beyond_noise((source, block, i), (target, answers.pixel[i], packed), sigmas);
        let agrees = beyond <= color_steps;
        if agrees {
            answers.bits[i] |= COLOR_AGREES;
        }
    }
}
