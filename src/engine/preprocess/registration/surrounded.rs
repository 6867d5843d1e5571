//! Whether the target shows a surface all around a position, so that it can be interpolated there: the last of what
//! [`SameSurface`] asks.

use super::matches::{RequiredTolerances, SAME, SURROUNDED, SurfaceMatches};
use super::noise_tolerance::{FoundSurfaces, granted_depth_noise_around};
use super::reproject::{ReprojectedRun, TargetRun};
use super::same_surface::{SameSurface, needed};
use crate::capture::INVALID_INVERSE_DEPTH;
use crate::capture::overlap::TargetLens;
use crate::preprocess::layers::CameraLayer;
use crate::simd::whole;

/// The pixels around the positions of a run, and what is granted to noise there.
struct CornersAround<'a, const N: usize> {
    toward: &'a [[f32; N]; 2],
    depths: &'a [[f32; N]; 3],
    inside: &'a [u32; N],
    granted: &'a [[f32; N]; 3],
    between: &'a [f32; N],
}

impl SameSurface {
    /// Whether the target shows the surface on all four pixels around each position, so that it can be interpolated there.
    #[inline(always)]
    pub(super) fn surround<const N: usize, const MEASURING: bool>(
        &self,
        lens: &TargetLens,
        surfaces: FoundSurfaces<'_, N>,
        between: &[f32; N],
        matches: &mut SurfaceMatches<N>,
        mut relevant: [u32; N],
        required: &mut RequiredTolerances<N>,
    ) {
        const BUT_SURROUNDED: u32 = SAME & !SURROUNDED;
        let FoundSurfaces { target: TargetRun { layer: target, reprojected }, facets: found } = surfaces;
        let mut candidates = 0;
        for i in 0..N {
            let so_far = matches.bits[i] & BUT_SURROUNDED == BUT_SURROUNDED;
            relevant[i] &= u32::from(so_far);
            candidates |= relevant[i];
        }
        let limits = &self.tolerances;
        if candidates == 0 || !limits.overlap {
            matches.bits.iter_mut().for_each(|bits| *bits |= SURROUNDED);
            return;
        }
        let Around { toward, pixels, inside } = Around::of(lens, target.width as u32, reprojected, relevant);
        let depths = self.depths_at(target, &pixels);
        let mut granted = [[0.0; N]; 3];
        if limits.depth_sigmas > 0.0 {
            granted = granted_depth_noise_around(target, reprojected, found, &depths, limits.depth_sigmas);
        }
        if lens.is_orthographic {
            let toward = &toward;
            let corners =
                CornersAround { toward, depths: &depths, inside: &inside, granted: &granted, between };
            self.surround_orthographic::<N, MEASURING>(lens, surfaces, &corners, matches, required);
            return;
        }
        for i in 0..N {
            let facet = &found[i];
            let here = facet.inverse_depth;
            let x = (reprojected.cell[0][i] + 0.5 - lens.center[0]) * (1.0 / lens.focal[0]);
            let y = (reprojected.cell[1][i] + 0.5 - lens.center[1]) * (1.0 / lens.focal[1]);
            let [nx, ny, nz] = facet.normal_in_camera;
            let across = nx * toward[0][i] * (1.0 / lens.focal[0]);
            let down = ny * toward[1][i] * (1.0 / lens.focal[1]);
            let along = nx * x + ny * y + nz;
            let mut all = inside[i] != 0;
            for (corner, shift) in [across, down, across + down].into_iter().enumerate() {
                let there = depths[corner][i];
                let distance = along * (here - there) + here * shift;
                let footprint = lens.side * here.max(there);
                // Both are rounded, and both are noisy.
                let step = target.depth_step_relative * (here + there) + granted[corner][i];
                let limit = (limits.depth_footprints * footprint).max(between[i]) + step;
                if MEASURING {
                    let needed = needed(distance.abs(), step, between[i], footprint);
                    let needed = if (between[i] > 0.0) & (there < 0.0) { 0.0 } else { needed };
                    required.depth[i] = required.depth[i].max(needed);
                }
                let both_or_neither_finite = (here == 0.0) == (there == 0.0);
                // A hole in noisy depth is no seam of the surface.
                let is_hole = (between[i] > 0.0) & (there < 0.0);
                let is_on_surface = (there >= 0.0) & (distance.abs() <= limit) & both_or_neither_finite;
                all &= is_hole | is_on_surface;
            }
            matches.bits[i] |= if all { SURROUNDED } else { 0 };
        }
    }

    /// The end of [`SameSurface::surround`] for an orthographic target.
    #[cold]
    #[inline(never)]
    fn surround_orthographic<const N: usize, const MEASURING: bool>(
        &self,
        lens: &TargetLens,
        surfaces: FoundSurfaces<'_, N>,
        corners: &CornersAround<'_, N>,
        matches: &mut SurfaceMatches<N>,
        required: &mut RequiredTolerances<N>,
    ) {
        let FoundSurfaces { target: TargetRun { layer: target, .. }, facets: found } = surfaces;
        let limits = &self.tolerances;
        for i in 0..N {
            let here = found[i].inverse_depth;
            let [nx, ny, nz] = found[i].normal_in_camera;
            let across = nx * corners.toward[0][i] / lens.focal[0];
            let down = ny * corners.toward[1][i] / lens.focal[1];
            let between = corners.between[i];
            let mut all = corners.inside[i] != 0;
            for (corner, shift) in [across, down, across + down].into_iter().enumerate() {
                let there = corners.depths[corner][i];
                let distance = nz * (here - there) + here * there * shift;
                let footprint = lens.side * here * there.abs();
                let step = target.depth_step_relative * (here + there) + corners.granted[corner][i];
                let limit = (limits.depth_footprints * footprint).max(between) + step;
                let is_hole = (between > 0.0) & (there < 0.0);
                if MEASURING && !is_hole {
                    let needed = needed(distance.abs(), step, between, footprint);
                    required.depth[i] = required.depth[i].max(needed);
                }
                let both_or_neither_finite = (here == 0.0) == (there == 0.0);
                all &= is_hole | ((there >= 0.0) & (distance.abs() <= limit) & both_or_neither_finite);
            }
            matches.bits[i] |= if all { SURROUNDED } else { 0 };
        }
    }

    /// The inverse depths of the target's samples that take part, at three pixels of each lane.
    #[inline(always)]
    fn depths_at<const N: usize>(&self, target: &CameraLayer, pixels: &[[u32; N]; 3]) -> [[f32; N]; 3] {
        let mut depths = [[0.0_f32; N]; 3];
        for corner in 0..3 {
            for i in 0..N {
                depths[corner][i] = target.geometry[pixels[corner][i] as usize].inverse_depth;
            }
        }
        if self.visible.hides_any {
            for corner in 0..3 {
                for i in 0..N {
                    let takes_part =
                        u32::from(target.level[pixels[corner][i] as usize]) <= self.visible.deepest;
                    depths[corner][i] = if takes_part { depths[corner][i] } else { INVALID_INVERSE_DEPTH };
                }
            }
        }
        depths
    }
}

/// A position this close to a pixel's center, in pixels, is that pixel: no neighbor takes part in interpolating there.
const CENTERED: f32 = 1.0 / 16.0;

/// The other three of the four pixels around each position in the target.
pub(super) struct Around<const N: usize> {
    /// Along each axis: 0 where the position is the pixel's center, else ±1 toward the pixel on the other side of it.
    pub(super) toward: [[f32; N]; 2],
    /// Index of the pixel beside, of the one above or below, and of the one across.
    pub(super) pixels: [[u32; N]; 3],
    /// 1 where all four are in the picture.
    pub(super) inside: [u32; N],
}

impl<const N: usize> Around<N> {
    #[inline(always)]
    pub(super) fn of(
        lens: &TargetLens,
        width: u32,
        reprojected: &ReprojectedRun<N>,
        relevant: [u32; N],
    ) -> Self {
        let mut toward = [[0.0_f32; N]; 2];
        let mut pixels = [[0_u32; N]; 3];
        let mut inside = [0_u32; N];
        for i in 0..N {
            let mut within = relevant[i] != 0;
            for axis in 0..2 {
                let off = reprojected.off_center[axis][i];
                let side = if off > CENTERED { 1.0 } else { 0.0 } - if off < -CENTERED { 1.0 } else { 0.0 };
                let cell = reprojected.cell[axis][i] + side;
                within &= (cell >= 0.0) & (cell < lens.size[axis]);
                toward[axis][i] = side;
            }
            let right = if within { reprojected.cell[0][i] + toward[0][i] } else { 0.0 };
            let below = if within { reprojected.cell[1][i] + toward[1][i] } else { 0.0 };
            let left = if within { reprojected.cell[0][i] } else { 0.0 };
            let above = if within { reprojected.cell[1][i] } else { 0.0 };
            pixels[0][i] = whole(above) * width + whole(right);
            pixels[1][i] = whole(below) * width + whole(left);
            pixels[2][i] = whole(below) * width + whole(right);
            inside[i] = u32::from(within);
        }
        Self { toward, pixels, inside }
    }
}
