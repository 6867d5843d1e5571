//! The same surface point? Compares a sample with what another camera saw where the sample's point is in its picture.
//!
//! Source: the paper (§3.2) compares pixels that map to each other; it leaves open when they show one surface. Here that is
//! decided in pixel footprints, by the distance to the other sample's tangent plane, and by normals and color, each with its
//! own threshold. Distances are compared times `w·wₜ`, both inverse depths, so that points at infinity need no division and
//! sixteen lanes no branch:
//!
//! ```text
//! |n·(q/w − rayₜ/wₜ)| ≤ τ max(s/w, sₜ/wₜ) + step/w + stepₜ/wₜ     s: side of a pixel at depth 1, τ: tolerance in footprints
//! |n·(q wₜ − rayₜ w)| ≤ τ max(s wₜ, sₜ w) + step wₜ + stepₜ w
//! ```
//!
//! For an orthographic camera, the side of a pixel at any depth stands in place of `s/w`, and a pixel's place in the picture plane,
//! moved by the depth along the z axis, in place of `ray/w`.
//!
//! `step` is what depths are rounded by. Where depth is noisy, a multiple of both samples' standard deviations is added to it.

use super::matches::{
    COLOR_AGREES, HAS_DEPTH, IN_FRONT, IN_VIEW, NEARER, NORMAL_AGREES, ON_SURFACE, Outcome,
    RequiredTolerances, SURROUNDED, SurfaceMatches, VALUES_AGREE,
};
use super::noise_tolerance::{
    ColorNoise, FoundSurfaces, SurfaceTolerances, VisibleLevels, depth_noise_between, granted_depth_noise,
};
use super::reproject::{PixelRun, ReprojectedRun, SourceRun, TargetRun};
use crate::capture::agree;
use crate::capture::overlap::Registration;
use crate::preprocess::layers::{COLOR_STEPS, CameraLayer, PackedColor, PackedGeometry, is_mixed};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::Settings;
use crate::simd::root_of_squares;

/// The same-surface test: its tolerances, and which samples of the target it sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SameSurface {
    pub(super) tolerances: SurfaceTolerances,
    pub(super) visible: VisibleLevels,
}

impl SameSurface {
    /// With the tolerances of `settings`; every sample is visible.
    pub(crate) fn new(settings: &Settings) -> Self {
        Self { tolerances: SurfaceTolerances::of(settings), visible: VisibleLevels::ALL }
    }

    /// Surfaces are the same up to a distance in footprints, whatever their normals and colors are.
    pub(crate) fn geometry_within(footprints: f32) -> Self {
        Self { tolerances: SurfaceTolerances::of_geometry(footprints), visible: VisibleLevels::ALL }
    }

    /// With the depth tolerances of `settings`. Normals, colors and neighboring pixels do not matter.
    pub(crate) fn geometry_of(settings: &Settings) -> Self {
        Self { tolerances: SurfaceTolerances::of(settings).geometry_alone(), visible: VisibleLevels::ALL }
    }

    /// This test for samples of `level`, which do not see those of deeper levels.
    pub(crate) fn at_level(self, level: SpanLevel) -> Self {
        Self { visible: VisibleLevels { deepest: u32::from(level), ..self.visible }, ..self }
    }

    /// This test for one pair of layers: where neither is noisy, nothing has to be granted to noise.
    pub(crate) fn between(mut self, source: &CameraLayer, target: &CameraLayer) -> Self {
        if !(source.has_color_noise() || target.has_color_noise()) {
            self.tolerances.color_sigmas = 0.0;
        }
        if !(source.has_depth_noise() || target.has_depth_noise()) {
            self.tolerances.depth_sigmas = 0.0;
        }
        if source.noise_between.is_none() && target.noise_between.is_none() {
            self.tolerances.between_sigmas = 0.0;
        }
        self
    }

    /// This test for a target that has samples of deeper levels, or has none.
    pub(crate) fn with_deeper(self, has_deeper: bool) -> Self {
        Self { visible: VisibleLevels { hides_any: has_deeper, ..self.visible }, ..self }
    }

    /// Whether the target's sample at a pixel is behind a sample of the source by more than the tolerance, along the target's
    /// optical axis. `depth` is that of the source's sample in target camera space, times its inverse depth.
    pub(crate) fn is_behind<const N: usize>(
        &self,
        registration: &Registration,
        source: SourceRun<'_, N>,
        lane: usize,
        target: &CameraLayer,
        pixel: usize,
        depth: f32,
    ) -> bool {
        let SourceRun { layer: source, run, .. } = source;
        let (w, there) = (run.inverse_depth[lane], target.inverse_depth[pixel]);
        let limits = &self.tolerances;
        let footprint = registration.larger_footprint(w, there);
        let noise = |own: f32, found: f32| root_of_squares(own * there, found * w);
        let granted =
            limits.depth_sigmas * noise(source.depth_noise_of(run.level), target.depth_noise(pixel));
        let between = limits.between_sigmas
            * noise(source.depth_noise_between_at(w), target.depth_noise_between(pixel));
        let step = source.depth_step_relative * there + target.depth_step_relative * w + granted;
        w - depth * there > (limits.depth_footprints * footprint).max(between) + step
    }

    /// What the target camera shows of the sample of `source` at pixel `(x, y)`.
    #[inline(always)]
    pub(crate) fn test(
        &self,
        registration: &Registration,
        source: &CameraLayer,
        x: usize,
        y: usize,
        target: &CameraLayer,
    ) -> Outcome {
        let block = PixelRun::<1>::new(source, x, y, 1);
        let reprojected = registration.reproject(&block, target.width);
        if reprojected.bits[0] & IN_VIEW == 0 {
            return if reprojected.bits[0] & IN_FRONT == 0 { Outcome::Behind } else { Outcome::OutsideView };
        }
        let source = SourceRun::of_layer(source, &block);
        let target = TargetRun { layer: target, reprojected: &reprojected };
        self.compare(registration, source, target, [1]).outcome(0)
    }

    /// The least depth tolerance, in footprints, at which the depths of the sample of `source` at `(x, y)` and of what the target shows
    /// there agree, what noise explains aside; infinite where they cannot.
    pub(crate) fn depth_tolerance_needed(
        &self,
        registration: &Registration,
        source: &CameraLayer,
        x: usize,
        y: usize,
        target: &CameraLayer,
    ) -> f32 {
        let block = PixelRun::<1>::new(source, x, y, 1);
        let reprojected = registration.reproject(&block, target.width);
        let source = SourceRun::of_layer(source, &block);
        let target = TargetRun { layer: target, reprojected: &reprojected };
        let mut required = RequiredTolerances::new(0.0);
        self.compare_measuring::<1, true>(registration, source, target, [1], &mut required);
        required.depth[0]
    }

    /// As [`SameSurface::test`], for display. Where samples of shorter spans would decide the outcome, but do not count, the outcome names
    /// them.
    pub(crate) fn explain(
        &self,
        registration: &Registration,
        source: &CameraLayer,
        x: usize,
        y: usize,
        target: &CameraLayer,
    ) -> Outcome {
        let outcome = self.test(registration, source, x, y, target);
        if self.visible.deepest == u32::from(SpanLevel::MAX)
            || !matches!(outcome, Outcome::NoDepth | Outcome::Seam)
        {
            return outcome;
        }
        match self.at_level(SpanLevel::MAX).test(registration, source, x, y, target) {
            Outcome::Same(_) => Outcome::ShorterSpan,
            of_all if outcome == Outcome::NoDepth => of_all,
            _ => outcome,
        }
    }

    /// Compares the samples of a block with what the target saw where they lie. Bits of samples that are not
    /// `relevant` may be incomplete.
    #[inline(always)]
    pub(crate) fn compare<const N: usize>(
        &self,
        registration: &Registration,
        source: SourceRun<'_, N>,
        target: TargetRun<'_, N>,
        relevant: [u32; N],
    ) -> SurfaceMatches<N> {
        let mut required = RequiredTolerances::new(0.0);
        self.compare_measuring::<N, false>(registration, source, target, relevant, &mut required)
    }

    /// [`SameSurface::compare`]; where `MEASURING`, with what each sample needs to be the same, if anything within these thresholds
    /// does.
    #[inline(always)]
    pub(crate) fn compare_measuring<const N: usize, const MEASURING: bool>(
        &self,
        registration: &Registration,
        source_run: SourceRun<'_, N>,
        target_run: TargetRun<'_, N>,
        relevant: [u32; N],
        required: &mut RequiredTolerances<N>,
    ) -> SurfaceMatches<N> {
        let TargetRun { layer: target, reprojected } = target_run;
        let limits = &self.tolerances;
        let mut found = [PackedGeometry::ABSENT; N];
        for i in 0..N {
            found[i] = target.geometry[reprojected.pixel[i] as usize];
        }
        let surfaces = FoundSurfaces { target: target_run, facets: &found };
        let mut granted = [0.0; N];
        if limits.depth_sigmas > 0.0 {
            granted = granted_depth_noise(source_run, surfaces, limits.depth_sigmas);
        }
        let mut between = [0.0; N];
        if limits.between_sigmas > 0.0 {
            between = depth_noise_between(source_run, surfaces, limits.between_sigmas);
        }
        let mut matches = SurfaceMatches { bits: reprojected.bits, pixel: reprojected.pixel, level: [0; N] };
        let granted = GrantedDepth { granted: &granted, between: &between };
        if registration.has_orthographic() {
            self.compare_orthographic::<N, MEASURING>(
                registration,
                source_run,
                surfaces,
                granted,
                &mut matches,
                required,
            );
        } else {
            self.compare_depths::<N, MEASURING, false>(
                registration,
                source_run,
                surfaces,
                granted,
                &mut matches,
                required,
            );
        }
        if !MEASURING && limits.are_of_geometry() {
            self.look_at_levels(target_run, &mut matches);
            return matches;
        }
        if !MEASURING && !self.visible.hides_any && !matches.any(relevant, ON_SURFACE) {
            return matches;
        }
        self.compare_colors::<N, MEASURING>(source_run, target_run, relevant, &mut matches, required);
        if self.tolerances.values && !target.values.is_empty() {
            compare_values(source_run, target_run, &mut matches);
        }
        self.surround::<N, MEASURING>(
            &registration.target,
            surfaces,
            &between,
            &mut matches,
            relevant,
            required,
        );
        matches
    }

    /// [`SameSurface::compare_depths`] where one of the cameras is orthographic. Apart, so that what is between cameras in perspective stays
    /// as fast as it is.
    #[cold]
    #[inline(never)]
    fn compare_orthographic<const N: usize, const MEASURING: bool>(
        &self,
        registration: &Registration,
        source: SourceRun<'_, N>,
        surfaces: FoundSurfaces<'_, N>,
        granted: GrantedDepth<'_, N>,
        matches: &mut SurfaceMatches<N>,
        required: &mut RequiredTolerances<N>,
    ) {
        self.compare_depths::<N, MEASURING, true>(registration, source, surfaces, granted, matches, required);
    }

    /// What depths and normals say.
    #[inline(always)]
    fn compare_depths<const N: usize, const MEASURING: bool, const ORTHOGRAPHIC: bool>(
        &self,
        registration: &Registration,
        source_run: SourceRun<'_, N>,
        surfaces: FoundSurfaces<'_, N>,
        GrantedDepth { granted, between }: GrantedDepth<'_, N>,
        matches: &mut SurfaceMatches<N>,
        required: &mut RequiredTolerances<N>,
    ) {
        let SourceRun { layer: source, run: block, .. } = source_run;
        let FoundSurfaces { target: TargetRun { layer: target, reprojected }, facets: found } = surfaces;
        let limits = &self.tolerances;
        let lens = &registration.target;
        let [ax, ay, az] = registration.axes;
        for i in 0..N {
            let facet = &found[i];
            let (w, there) = (block.inverse_depth[i], facet.inverse_depth);
            let x = (reprojected.cell[0][i] + 0.5 - lens.center[0]) * (1.0 / lens.focal[0]);
            let y = (reprojected.cell[1][i] + 0.5 - lens.center[1]) * (1.0 / lens.focal[1]);
            let [qx, qy, qz] = [reprojected.point[0][i], reprojected.point[1][i], reprojected.point[2][i]];
            let [nx, ny, nz] = facet.normal_in_camera;
            // A pixel's place comes with its depth in perspective alone.
            let plane = if ORTHOGRAPHIC && lens.is_orthographic { w * there } else { w };
            let distance =
                nx * (qx * there - x * plane) + ny * (qy * there - y * plane) + nz * (qz * there - w);
            let footprint = if ORTHOGRAPHIC {
                registration.larger_footprint(w, there)
            } else {
                (registration.source_side * there).max(lens.side * w)
            };
            let step = source.depth_step_relative * there + target.depth_step_relative * w + granted[i];
            let both_or_neither_finite = (w == 0.0) == (there == 0.0);
            let limit = (limits.depth_footprints * footprint).max(between[i]) + step;
            let on_surface = (distance.abs() <= limit) & both_or_neither_finite;
            let (mx, my, mz) = (block.normal[0][i], block.normal[1][i], block.normal[2][i]);
            let cosine = (ax.x * mx + ay.x * my + az.x * mz) * nx
                + (ax.y * mx + ay.y * my + az.y * mz) * ny
                + (ax.z * mx + ay.z * my + az.z * mz) * nz;
            let facing = (block.known[i] == 0) | (cosine >= limits.normal_cosine);
            if MEASURING {
                required.depth[i] = needed(distance.abs(), step, between[i], footprint);
                required.turn[i] = if block.known[i] == 0 { 0.0 } else { 1.0 - cosine };
            }
            matches.bits[i] |= if there >= 0.0 { HAS_DEPTH } else { 0 }
                | if on_surface { ON_SURFACE } else { 0 }
                | if there * qz > w { NEARER } else { 0 }
                | if facing { NORMAL_AGREES } else { 0 }
                | VALUES_AGREE;
        }
    }

    /// What is left to ask where neither colors nor normals nor the pixels around count: whether the target's samples take part.
    #[inline(always)]
    fn look_at_levels<const N: usize>(
        &self,
        TargetRun { layer: target, reprojected }: TargetRun<'_, N>,
        matches: &mut SurfaceMatches<N>,
    ) {
        for i in 0..N {
            let level = u32::from(target.level[reprojected.pixel[i] as usize]);
            matches.bits[i] &= if level <= self.visible.deepest { u32::MAX } else { !HAS_DEPTH };
            matches.bits[i] |= COLOR_AGREES | NORMAL_AGREES | SURROUNDED;
            matches.level[i] = level;
        }
    }

    /// What the target's colors say: whether its samples take part, have normals, and agree in color.
    #[inline(always)]
    fn compare_colors<const N: usize, const MEASURING: bool>(
        &self,
        source: SourceRun<'_, N>,
        target_run: TargetRun<'_, N>,
        relevant: [u32; N],
        matches: &mut SurfaceMatches<N>,
        required: &mut RequiredTolerances<N>,
    ) {
        let block = source.run;
        let TargetRun { layer: target, reprojected } = target_run;
        let limits = &self.tolerances;
        let mut packed_colors = [PackedColor::ABSENT; N];
        for i in 0..N {
            packed_colors[i] = target.packed_colors[reprojected.pixel[i] as usize];
        }
        let yields = yields(block, target, reprojected);
        let color_limit = (limits.color_steps * COLOR_STEPS) as i32;
        for i in 0..N {
            let color = packed_colors[i].color();
            let furthest = (block.color[0][i] - color[0])
                .abs()
                .max((block.color[1][i] - color[1]).abs())
                .max((block.color[2][i] - color[2]).abs());
            let level = packed_colors[i].level();
            matches.bits[i] &= if level <= self.visible.deepest { u32::MAX } else { !HAS_DEPTH };
            matches.bits[i] |= if packed_colors[i].has_normal() { 0 } else { NORMAL_AGREES }
                | if (yields[i] != 0) | (furthest <= color_limit) { COLOR_AGREES } else { 0 };
            matches.level[i] = level;
            if MEASURING {
                required.turn[i] = if packed_colors[i].has_normal() { required.turn[i] } else { 0.0 };
                required.color[i] = if yields[i] != 0 { 0.0 } else { furthest as f32 * (1.0 / COLOR_STEPS) };
            }
        }
        if limits.color_sigmas > 0.0 {
            let noise = ColorNoise { source, target, packed_colors: &packed_colors, limits };
            noise.grant::<MEASURING>(relevant, matches, required);
        }
    }
}

/// What noise is granted of the distance of each sample from the surface, on top of the tolerance and in place of it.
#[derive(Clone, Copy)]
struct GrantedDepth<'a, const N: usize> {
    granted: &'a [f32; N],
    between: &'a [f32; N],
}

/// Takes [`VALUES_AGREE`] from the samples whose scalar values differ from the target's by more than their tolerances.
#[cold]
#[inline(never)]
fn compare_values<const N: usize>(
    source: SourceRun<'_, N>,
    TargetRun { layer: target, reprojected }: TargetRun<'_, N>,
    matches: &mut SurfaceMatches<N>,
) {
    let tolerances = &target.value_tolerances;
    for lane in 0..N {
        if matches.bits[lane] & ON_SURFACE == 0 {
            continue;
        }
        let found = target.values.of(reprojected.pixel[lane] as usize);
        let are_same = |own: &[f32]| {
            own.iter()
                .zip(found)
                .zip(tolerances)
                .all(|((own, found), tolerance)| agree(*own, *found, *tolerance))
        };
        if !source.values_of(lane, tolerances.len()).is_some_and(are_same) {
            matches.bits[lane] &= !VALUES_AGREE;
        }
    }
}

/// For which samples color counts as equal: a mixed one's belongs to no surface, so that a clean witness need not agree with it.
#[inline(always)]
fn yields<const N: usize>(
    block: &PixelRun<N>,
    target: &CameraLayer,
    reprojected: &ReprojectedRun<N>,
) -> [u32; N] {
    let mut yields = [0_u32; N];
    if is_mixed(block.rank.iter().fold(0, |all, rank| all | rank)) {
        for i in 0..N {
            let is_clean = !is_mixed(target.ranks[reprojected.pixel[i] as usize]);
            yields[i] = u32::from(is_mixed(block.rank[i]) & is_clean);
        }
    }
    yields
}

/// The tolerance at which a distance is granted, where `footprint` is granted for each footprint of tolerance, `between` in place
/// of a smaller tolerance, and `step` on top.
#[inline(always)]
pub(super) fn needed(distance: f32, step: f32, between: f32, footprint: f32) -> f32 {
    if distance <= between + step { 0.0 } else { (distance - step) / footprint }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::overlap::OverlapGraph;
    use crate::demo::{Demo, DemoSpec};
    use crate::job::Job;
    use crate::preprocess::pruning::{rated, static_layers};
    use crate::preprocess::temporal::ROOT;
    use crate::settings::CaptureSettings;
    use crate::simd::LANES;

    #[test]
    fn what_is_decided_before_colors_are_read_is_decided_as_by_the_whole_comparison() {
        let (settings, job) = (Settings::default(), Job::new());
        let spec = DemoSpec::new("orrery").cameras(3).frames(1).size((64, 48));
        let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
        let scan = crate::preprocess::scan(&capture, &settings, &job).unwrap();
        let layers = static_layers(&capture, &scan, &settings, &job).unwrap();
        let layers = rated(&capture, layers, &settings, &job).unwrap();
        let pairs = OverlapGraph::complete(&capture.cameras);
        let [mut beside_surfaces, mut on_surfaces] = [0; 2];
        for limits in [
            SameSurface::new(&settings).with_deeper(false),
            SameSurface::geometry_of(&settings).at_level(ROOT),
        ] {
            for (row, column) in (0..48).flat_map(|row| (0..64).step_by(LANES).map(move |at| (row, at))) {
                let run = PixelRun::<LANES>::new(&layers[0], column, row, u32::MAX);
                for (other, way) in pairs.others(0) {
                    let reprojected = way.reproject(&run, layers[other].width);
                    let relevant = reprojected.bits.map(|bits| u32::from(bits & IN_VIEW != 0));
                    let source = SourceRun::of_layer(&layers[0], &run);
                    let target = TargetRun { layer: &layers[other], reprojected: &reprojected };
                    let found = limits.compare(way, source, target, relevant);
                    let mut required = RequiredTolerances::new(0.0);
                    let whole =
                        limits.compare_measuring::<LANES, true>(way, source, target, relevant, &mut required);
                    for lane in (0..LANES).filter(|lane| relevant[*lane] != 0) {
                        assert_eq!(found.outcome(lane), whole.outcome(lane), "{row}, {column} + {lane}");
                    }
                    let is_beside = !whole.any(relevant, ON_SURFACE);
                    beside_surfaces += usize::from(is_beside);
                    on_surfaces += usize::from(!is_beside);
                    if limits.tolerances.are_of_geometry() {
                        let read = |lane: &usize| relevant[*lane] != 0;
                        assert!((0..LANES).filter(read).all(|lane| found.level[lane] == whole.level[lane]));
                    }
                }
            }
        }
        assert!(beside_surfaces > 20 && on_surfaces > 100, "{beside_surfaces}, {on_surfaces}");
    }
}
