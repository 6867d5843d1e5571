//! The pixels around positions in a camera, where samples would be interpolated.

use super::reproject::ReprojectedRun;
use crate::capture::overlap::TargetLens;
use crate::simd::whole;

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
