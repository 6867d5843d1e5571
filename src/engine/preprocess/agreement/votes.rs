//! What other cameras say about a sample: they confirm it, look past it, or cannot tell.
//!
//! Purpose: a sample that one camera misread floats before what all others see, and wins wherever the nearest one wins. Cameras
//! that look past it contradict it.
//!
//! Source: support and free-space violations are counted as in P. Merrell et al., *Real-Time Visibility-Based Fusion of Depth
//! Maps*, ICCV 2007; that a whole neighborhood has to be behind is the depth quality check of the MPEG immersive video test
//! model. What differs: a camera that may have missed a thing cannot tell. That holds for
//! - all cameras where the thing is one pixel wide, and cameras that resolve it less than half as well as the sample's own: thin
//!   things slip between pixels;
//! - cameras that see anything as near in the 3×3 pixels: it is the thing itself beside its silhouette;
//! - cameras whose pixels change over time: their clocks may differ.
//!
//! And a flying pixel's own camera counts as one that looks past it.
//!
//! Thresholds are those of [`crate::preprocess::registration`]: footprints, or noise where it exceeds them.

use crate::capture::overlap::{OverlapGraph, Registration};
use crate::preprocess::layers::{CameraLayer, PackedGeometry};
use crate::preprocess::registration::{
    HAS_DEPTH, IN_VIEW, NEARER, ON_SURFACE, PixelRun, SameSurface, SourceRun, TargetRun,
};
use crate::preprocess::temporal::{ROOT, SpanLevel};
use crate::samples::{Vote, VoteCounts};
use crate::settings::{AgreementRule, PruningMethod, Settings};

/// A pixel of the target may be this many times as large as the sample's own: a surface that the sample shows cannot slip between.
pub(super) const RESOLVES: f32 = 2.0;

/// Neighbors in one picture are of one surface while their depths differ by no more than this, or by what noise explains.
const SURFACE_FOOTPRINTS: f32 = 8.0;
const SIGMAS: f32 = 3.0;

/// Whether the target's pixels are too large to show a sample at inverse depth `w`, whose depth there, times `w`, is `depth`.
fn is_too_coarse(registration: &Registration, w: f32, depth: f32) -> bool {
    if registration.has_orthographic() {
        return registration.coarseness(w, depth) > RESOLVES;
    }
    registration.target.side * depth > RESOLVES * registration.source_side
}

/// The directions in which a thing may be thin.
const ACROSS: [(isize, isize); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

/// Lets other cameras vote on samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VoteTest {
    limits: SameSurface,
    level: SpanLevel,
    margin: u32,
    depth_footprints: f32,
    is_on: bool,
}

/// The votes on some pixels of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VotedRun<const N: usize> {
    confirm: [u32; N],
    look_past: [u32; N],
}

impl<const N: usize> VotedRun<N> {
    /// No votes.
    pub(crate) const NONE: Self = Self { confirm: [0; N], look_past: [0; N] };

    pub(crate) fn counts(&self, lane: usize) -> VoteCounts {
        VoteCounts { confirm: self.confirm[lane], look_past: self.look_past[lane] }
    }
}

impl VoteTest {
    /// With the tolerances of `settings`, for samples of `level`, which do not see those of deeper levels.
    pub(crate) fn new(settings: &Settings, level: SpanLevel) -> Self {
        let pruning = &settings.pruning;
        Self {
            limits: SameSurface::geometry_of(settings).at_level(level),
            level,
            margin: pruning.agreement_margin,
            depth_footprints: pruning.depth_tolerance,
            is_on: pruning.agreement == AgreementRule::Majority && pruning.method != PruningMethod::Off,
        }
    }

    /// This test for samples of `level`.
    pub(crate) fn at_level(self, level: SpanLevel) -> Self {
        Self { limits: self.limits.at_level(level), level, ..self }
    }

    /// This test, with this many footprints by which a thing has to be in front of its surroundings to count as thin.
    pub(crate) fn thin_beyond(self, depth_footprints: f32) -> Self {
        Self { depth_footprints, ..self }
    }

    /// Whether other cameras vote.
    pub(crate) fn is_on(&self) -> bool {
        self.is_on
    }

    /// Whether the votes contradict a sample, which flies or does not.
    pub(crate) fn is_contradicted(&self, counts: VoteCounts, is_flying: bool) -> bool {
        self.is_on && counts.contradict(self.margin, is_flying)
    }

    /// Which samples the votes contradict if `more` cameras look past each beside those that voted. `flying` is the set of flying samples.
    #[inline(always)]
    pub(crate) fn contradicted<const N: usize>(&self, votes: &VotedRun<N>, flying: u32, more: u32) -> u32 {
        let mut contradicted = 0;
        for lane in 0..N {
            let VoteCounts { confirm, look_past } = votes.counts(lane);
            let counts = VoteCounts { confirm, look_past: look_past + more };
            contradicted |= u32::from(counts.contradict(self.margin, flying >> lane & 1 == 1)) << lane;
        }
        contradicted
    }

    /// Adds the votes of a camera on the `asked` samples of a block. `is_thin` says of a lane whether its sample is of a thing one pixel
    /// wide ([`VoteTest::is_thin`]).
    #[inline(always)]
    pub(crate) fn add<const N: usize>(
        &self,
        registration: &Registration,
        source: SourceRun<'_, N>,
        target: &CameraLayer,
        asked: u32,
        is_thin: impl Fn(usize) -> bool,
        votes: &mut VotedRun<N>,
    ) {
        let reprojected = registration.reproject(source.run, target.width);
        let mut relevant = [0; N];
        let mut any = 0;
        for i in 0..N {
            relevant[i] = (asked >> i & 1) & u32::from(reprojected.bits[i] & IN_VIEW != 0);
            any |= relevant[i];
        }
        if any == 0 {
            return;
        }
        let limits = self.limits.between(source.layer, target);
        let target = TargetRun { layer: target, reprojected: &reprojected };
        let matches = limits.compare(registration, source, target, relevant);
        let mut suspect = 0_u32;
        for i in 0..N {
            let bits = matches.bits[i];
            let sees = (relevant[i] != 0) & (bits & HAS_DEPTH != 0);
            votes.confirm[i] += u32::from(sees & (bits & ON_SURFACE != 0));
            let farther = sees & (bits & (ON_SURFACE | NEARER) == 0) & (matches.level[i] == u32::from(ROOT));
            suspect |= u32::from(farther) << i;
        }
        while suspect != 0 {
            let lane = suspect.trailing_zeros() as usize;
            suspect &= suspect - 1;
            let looks_past = self.looks_past(&limits, registration, source, target, lane, &is_thin);
            votes.look_past[lane] += u32::from(looks_past);
        }
    }

    /// Whether all that the target sees around a point is behind it, and it would have seen the sample's surface.
    #[cold]
    #[inline(never)]
    fn looks_past<const N: usize>(
        &self,
        limits: &SameSurface,
        registration: &Registration,
        source: SourceRun<'_, N>,
        target: TargetRun<'_, N>,
        lane: usize,
        is_thin: impl Fn(usize) -> bool,
    ) -> bool {
        let block = source.run;
        let TargetRun { layer: target, reprojected } = target;
        let depth = reprojected.point[2][lane];
        if block.inverse_depth[lane] <= 0.0 || is_too_coarse(registration, block.inverse_depth[lane], depth) {
            return false;
        }
        if is_thin(lane) {
            return false;
        }
        let [x, y] = [reprojected.cell[0][lane] as usize, reprojected.cell[1][lane] as usize];
        let rows = y.saturating_sub(1)..(y + 2).min(target.height());
        rows.flat_map(|row| (x.saturating_sub(1)..(x + 2).min(target.width)).map(move |x| (x, row))).all(
            |(x, y)| {
                let pixel = y * target.width + x;
                let level = target.level[pixel];
                // Samples of deeper levels are not there yet, and those of shorter spans may be late.
                target.geometry[pixel] == PackedGeometry::ABSENT
                    || level > self.level
                    || (level == ROOT && limits.is_behind(registration, source, lane, target, pixel, depth))
            },
        )
    }

    /// Whether a sample belongs to a thing one pixel wide in its own picture: what is on both sides of it is behind, and what is
    /// beside it elsewhere does not. A sample all by itself is a stray one. The registration is one of its camera.
    pub(crate) fn is_thin(&self, layer: &CameraLayer, pixel: usize, own: &Registration) -> bool {
        let (x, y) = (pixel % layer.width, pixel / layer.width);
        let here = layer.inverse_depth[pixel];
        let side = own.relative_source_side(here);
        let noise = SIGMAS * std::f32::consts::SQRT_2 * layer.depth_noise_between(pixel);
        let [apart, together] =
            [self.depth_footprints, SURFACE_FOOTPRINTS].map(|footprints| here * noise.max(footprints * side));
        let depth_at = |(dx, dy): (isize, isize)| {
            let x = x.checked_add_signed(dx).filter(|x| *x < layer.width)?;
            let y = y.checked_add_signed(dy).filter(|y| *y < layer.height())?;
            let neighbor = y * layer.width + x;
            let is_there = layer.inverse_depth[neighbor] >= 0.0 && layer.level[neighbor] <= self.level;
            is_there.then(|| layer.inverse_depth[neighbor])
        };
        let is_behind = |toward| depth_at(toward).is_some_and(|there| here - there > apart);
        let is_beside = |toward| depth_at(toward).is_some_and(|there| (here - there).abs() <= together);
        let opposite = |(dx, dy): (isize, isize)| (-dx, -dy);
        ACROSS.iter().any(|&toward| is_behind(toward) && is_behind(opposite(toward)))
            && ACROSS.iter().any(|&toward| is_beside(toward) || is_beside(opposite(toward)))
    }

    /// The votes of all other cameras on the sample of `camera` at `pixel`.
    pub(crate) fn counts(
        &self,
        pairs: &OverlapGraph<'_>,
        layers: &[CameraLayer],
        camera: usize,
        pixel: u32,
    ) -> VoteCounts {
        let others = pairs.others(camera);
        let votes = others.map(|(other, way)| self.vote(way, layers, camera, pixel, other));
        votes.fold(VoteCounts::default(), VoteCounts::with)
    }

    /// The vote of camera `other` on the sample of `camera` at `pixel`.
    pub(crate) fn vote(
        &self,
        registration: &Registration,
        layers: &[CameraLayer],
        camera: usize,
        pixel: u32,
        other: usize,
    ) -> Vote {
        let (layer, target) = (&layers[camera], &layers[other]);
        if target.geometry.is_empty() {
            return Vote::CannotTell;
        }
        let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
        let block = PixelRun::<1>::new(layer, x, y, 1);
        let mut votes = VotedRun::NONE;
        let is_thin = |_| self.is_thin(layer, pixel as usize, registration);
        self.add(registration, SourceRun::of_layer(layer, &block), target, 1, is_thin, &mut votes);
        match votes.counts(0) {
            VoteCounts { confirm: 1, .. } => Vote::Confirms,
            VoteCounts { look_past: 1, .. } => Vote::LooksPast,
            _ => Vote::CannotTell,
        }
    }

    /// Whether the votes of all other cameras contradict the sample of `camera` at `pixel`.
    pub(crate) fn contradicts(
        &self,
        pairs: &OverlapGraph<'_>,
        layers: &[CameraLayer],
        camera: usize,
        pixel: u32,
    ) -> bool {
        if !self.is_on {
            return false;
        }
        let is_flying = layers[camera].packed_colors[pixel as usize].is_flying();
        let others = pairs.others(camera);
        let (mut counts, mut left) = (VoteCounts::default(), others.len() as u32);
        for (other, way) in others {
            // The remaining cameras are too few to contradict it.
            let most = VoteCounts { look_past: counts.look_past + left, ..counts };
            if !most.contradict(self.margin, is_flying) {
                return false;
            }
            left -= 1;
            counts = counts.with(self.vote(way, layers, camera, pixel, other));
        }
        counts.contradict(self.margin, is_flying)
    }
}
