//! Colors that differ by more than the tolerance, but by no more than the noise of both cameras explains.

use super::answers::{COLOR_AGREES, Needs, SAME, SURROUNDED, SurfaceMatches};
use super::reproject::PixelRun;
use crate::preprocess::layers::{COLOR_STEPS, CameraLayer, Look};

/// All that has to hold before the color of a sample matters.
const BUT_LOOKS: u32 = SAME & !(COLOR_AGREES | SURROUNDED);

/// The color tolerance that each sample needs once noise is granted.
#[cold]
#[inline(never)]
pub(crate) fn tell_noise<const N: usize>(
    (source, block): (&CameraLayer, &PixelRun<N>),
    (target, looks): (&CameraLayer, &[Look; N]),
    answers: &SurfaceMatches<N>,
    sigmas: f32,
    needs: &mut Needs<N>,
) {
    for (i, look) in looks.iter().enumerate() {
        if answers.bits[i] & BUT_LOOKS != BUT_LOOKS || needs.color[i] <= needs.few_steps {
            continue;
        }
        let beyond = beyond_noise((source, block, i), (target, answers.pixel[i], look), sigmas);
        needs.color[i] = needs.color[i].min(beyond);
    }
}

/// By how many 8-bit steps the color of a block's sample differs from one of the target beyond what the noise of both explains: of
/// the channel where that is most.
#[inline(always)]
fn beyond_noise<const N: usize>(
    (source, block, lane): (&CameraLayer, &PixelRun<N>, usize),
    (target, found, look): (&CameraLayer, u32, &Look),
    sigmas: f32,
) -> f32 {
    let pixel = block.row * source.width + block.column + lane;
    let found_color = look.color();
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
    (target, looks): (&CameraLayer, &[Look; N]),
    answers: &mut SurfaceMatches<N>,
    (color_steps, sigmas): (f32, f32),
    wanted: [u32; N],
) {
    for (i, look) in looks.iter().enumerate() {
        if wanted[i] == 0 || answers.bits[i] & (BUT_LOOKS | COLOR_AGREES) != BUT_LOOKS {
            continue;
        }
        let beyond = beyond_noise((source, block, i), (target, answers.pixel[i], look), sigmas);
        let agrees = beyond <= color_steps;
        if agrees {
            answers.bits[i] |= COLOR_AGREES;
        }
    }
}
