//! Colors and depths that differ by more than the tolerance, but by no more than the noise of both cameras explains.

use super::matches::{COLOR_AGREES, RequiredTolerances, SAME, SURROUNDED, SurfaceMatches};
use super::reproject::{ReprojectedRun, SourceRun, TargetRun};
use crate::preprocess::layers::{COLOR_STEPS, CameraLayer, PackedColor, PackedGeometry};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::Settings;
use crate::simd::root_of_squares;

/// All conditions that come before color matters.
const BEFORE_COLOR: u32 = SAME & !(COLOR_AGREES | SURROUNDED);

/// The surfaces that the target found where the samples of a run lie.
#[derive(Clone, Copy)]
pub(crate) struct FoundSurfaces<'a, const N: usize> {
    pub(crate) target: TargetRun<'a, N>,
    pub(crate) facets: &'a [PackedGeometry; N],
}

/// What the noise of both cameras' colors is judged by.
#[derive(Clone, Copy)]
pub(super) struct ColorNoise<'a, const N: usize> {
    pub(super) source: SourceRun<'a, N>,
    pub(super) target: &'a CameraLayer,
    /// The target's colors at the samples' positions.
    pub(super) packed_colors: &'a [PackedColor; N],
    pub(super) limits: &'a SurfaceTolerances,
}

impl<const N: usize> ColorNoise<'_, N> {
    /// Where colors differ by more than the tolerance, adds what the measured noise of both explains; where `MEASURING`, adds it to the
    /// tolerance that each sample requires.
    #[cold]
    #[inline(never)]
    pub(super) fn grant<const MEASURING: bool>(
        self,
        relevant: [u32; N],
        matches: &mut SurfaceMatches<N>,
        required: &mut RequiredTolerances<N>,
    ) {
        for lane in 0..N {
            let bits = matches.bits[lane];
            let may_matter = bits & BEFORE_COLOR == BEFORE_COLOR;
            let is_open = may_matter && relevant[lane] != 0 && bits & COLOR_AGREES == 0;
            let is_measured = MEASURING && may_matter && required.color[lane] > required.negligible_steps;
            if !(is_open || is_measured) {
                continue;
            }
            let beyond = self.beyond_noise(lane, matches.pixel[lane] as usize);
            if is_measured {
                required.color[lane] = required.color[lane].min(beyond);
            }
            if is_open && beyond <= self.limits.color_steps {
                matches.bits[lane] |= COLOR_AGREES;
            }
        }
    }

    /// By how many 8-bit steps the color of a sample differs from that of the target's pixel `found` beyond what the noise of both
    /// explains: of the channel where that is most.
    #[inline(always)]
    fn beyond_noise(&self, lane: usize, found: usize) -> f32 {
        let (SourceRun { layer: source, run, .. }, target) = (self.source, self.target);
        let sigmas = self.limits.color_sigmas;
        let found_color = self.packed_colors[lane].color();
        let of_channel = |channel: usize| {
            let [a, b] =
                [run.color[channel][lane], found_color[channel]].map(|color| color as f32 / COLOR_STEPS);
            let noise = root_of_squares(source.color_noise_of(run.level, a), target.color_noise(found, b));
            let between = root_of_squares(source.color_noise_between(a), target.color_noise_between(b));
            let difference = (a - b).abs();
            if difference <= sigmas * between { 0.0 } else { difference - sigmas * noise }
        };
        of_channel(0).max(of_channel(1)).max(of_channel(2))
    }
}

/// How far noise may put the points of a run off the surfaces that the target found: relative standard deviations of depth, of the
/// source by inverse depth, of the target by pixel.
#[inline(always)]
fn off_surfaces<const N: usize>(
    source: SourceRun<'_, N>,
    found: FoundSurfaces<'_, N>,
    sigmas: f32,
    own_noise: impl Fn(&CameraLayer, f32) -> f32,
    noise: impl Fn(&CameraLayer, usize) -> f32,
) -> [f32; N] {
    let SourceRun { layer: source, run, .. } = source;
    let TargetRun { layer: target, reprojected } = found.target;
    let mut off = [0.0; N];
    for (lane, off) in off.iter_mut().enumerate() {
        let (w, there) = (run.inverse_depth[lane], found.facets[lane].inverse_depth);
        if w > 0.0 && there > 0.0 {
            let own = own_noise(source, w) * there;
            *off = sigmas * root_of_squares(own, noise(target, reprojected.pixel[lane] as usize) * w);
        }
    }
    off
}

/// By how much the noise of both cameras may move the points of a run off the surfaces that the target found: for each its
/// distance along the ray, times both inverse depths as in the [comparison](super::same_surface).
#[cold]
#[inline(never)]
pub(crate) fn granted_depth_noise<const N: usize>(
    source: SourceRun<'_, N>,
    found: FoundSurfaces<'_, N>,
    sigmas: f32,
) -> [f32; N] {
    let level = source.run.level;
    off_surfaces(source, found, sigmas, |layer, _| layer.depth_noise_of(level), CameraLayer::depth_noise)
}

/// How far apart noise between cameras puts one surface: as [`granted_depth_noise`], but in place of the tolerance, not on top
/// of it.
#[cold]
#[inline(never)]
pub(crate) fn depth_noise_between<const N: usize>(
    source: SourceRun<'_, N>,
    found: FoundSurfaces<'_, N>,
    sigmas: f32,
) -> [f32; N] {
    let own_noise = CameraLayer::depth_noise_between_at;
    off_surfaces(source, found, sigmas, own_noise, CameraLayer::depth_noise_between)
}

/// The same for the samples that the target found and three of their neighbors each, which are as noisy: by corner.
#[cold]
#[inline(never)]
pub(crate) fn granted_depth_noise_around<const N: usize>(
    target: &CameraLayer,
    carried: &ReprojectedRun<N>,
    found: &[PackedGeometry; N],
    neighbors: &[[f32; N]; 3],
    sigmas: f32,
) -> [[f32; N]; 3] {
    let noise = carried.pixel.map(|pixel| sigmas * target.depth_noise(pixel as usize));
    neighbors.map(|depths| {
        std::array::from_fn(|lane| {
            let (here, there) = (found[lane].inverse_depth, depths[lane]);
            noise[lane] * (here * here + there * there).sqrt()
        })
    })
}

/// Tolerances of the same-surface test, converted once.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceTolerances {
    pub(super) depth_footprints: f32,
    pub(super) normal_cosine: f32,
    pub(super) color_steps: f32,
    /// Standard deviations of noise that are granted beside the tolerances.
    pub(super) color_sigmas: f32,
    pub(super) depth_sigmas: f32,
    /// Standard deviations of depth noise between cameras that are granted where they exceed the tolerance.
    pub(super) between_sigmas: f32,
    /// Whether the target has to show the surface all around the point.
    pub(super) overlap: bool,
    /// Whether scalar values have to agree.
    pub(super) values: bool,
}

/// Samples of deeper levels are invisible.
#[derive(Clone, Copy, Debug)]
pub(super) struct VisibleLevels {
    pub(super) deepest: u32,
    /// Whether the target may have samples of deeper levels.
    pub(super) hides_any: bool,
}

impl VisibleLevels {
    pub(super) const ALL: Self = Self { deepest: SpanLevel::MAX as u32, hides_any: true };
}

/// Two noisy colors of one surface, and two noisy depths, differ by less than this many standard deviations of their difference.
const SIGMAS: f32 = 3.0;

impl SurfaceTolerances {
    /// Those of `settings`.
    pub(super) fn of(settings: &Settings) -> Self {
        let pruning = &settings.pruning;
        Self {
            depth_footprints: pruning.depth_tolerance,
            normal_cosine: pruning.normal_tolerance.to_radians().cos(),
            color_steps: pruning.color_tolerance,
            color_sigmas: settings.spans.noise * SIGMAS,
            depth_sigmas: settings.spans.noise * SIGMAS,
            between_sigmas: settings.spans.noise * SIGMAS,
            overlap: pruning.overlap,
            values: true,
        }
    }

    /// A distance alone, whatever normals and colors are.
    pub(super) fn of_geometry(footprints: f32) -> Self {
        Self {
            depth_footprints: footprints,
            normal_cosine: f32::NEG_INFINITY,
            color_steps: f32::from(u16::MAX),
            color_sigmas: 0.0,
            depth_sigmas: 0.0,
            between_sigmas: 0.0,
            overlap: false,
            values: false,
        }
    }

    /// Whether normals, colors, values and the pixels around a point do not matter.
    #[inline(always)]
    pub(super) fn are_of_geometry(&self) -> bool {
        self.normal_cosine == f32::NEG_INFINITY
    }

    /// These, whatever normals and colors are, and at pixels alone.
    pub(super) fn geometry_alone(self) -> Self {
        let Self { depth_sigmas, between_sigmas, .. } = self;
        Self { depth_sigmas, between_sigmas, ..Self::of_geometry(self.depth_footprints) }
    }
}
