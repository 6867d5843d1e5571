//! Registration (the paper, §3.2): carries every sample into every other camera.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2, "mapping every image in the same
//! time frame to every other image in that time frame". What differs: sixteen pixels of a row are carried at once, and pairs
//! that cannot see each other are left out ([`crate::capture::overlap`]). All of it is linear in `(ray, w)`, where `w = 1/z`:
//! `q = R·ray + t·w` is the point in the target camera times `w`, for points at infinity as well; where a camera is orthographic
//! [`Registration`] says what it is. Whether what the target saw there is the same surface point is decided in
//! [`super::same_surface`].

use super::matches::{IN_FRONT, IN_VIEW};
use crate::capture::INVALID_INVERSE_DEPTH;
use crate::capture::overlap::Registration;
use crate::preprocess::layers::{
    ABSENT_RANK, CameraLayer, PackedColor, PackedGeometry, Rank, RatedSamples, SampleRun,
};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel};
use crate::simd::{self, LANES, whole};

/// Pixels of a row, some of which hold samples to be carried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelRun<const N: usize = LANES> {
    pub(crate) column: usize,
    pub(crate) row: usize,
    /// The level of the samples: of the first where they are of several.
    pub(crate) level: SpanLevel,
    pub(crate) inverse_depth: [f32; N],
    pub(crate) normal: [[f32; N]; 3],
    pub(crate) color: [[i32; N]; 3],
    pub(crate) known: [u32; N],
    /// Ranks of the samples.
    pub(crate) rank: [Rank; N],
}

/// Pixels of a row from `(column, row)` on; `nothing` beyond its end.
#[inline(always)]
pub(crate) fn lanes_of<T: Copy, const N: usize>(
    plane: &[T],
    width: usize,
    (column, row): (usize, usize),
    nothing: T,
) -> [T; N] {
    let rest = &plane[row * width + column..(row + 1) * width];
    if let Some(lanes) = rest.first_chunk() {
        return *lanes;
    }
    let mut lanes = [nothing; N];
    lanes.iter_mut().zip(rest).for_each(|(lane, &value)| *lane = value);
    lanes
}

impl<const N: usize> ReprojectedRun<N> {
    /// Nothing was carried.
    pub(crate) const NOWHERE: Self = Self {
        point: [[0.0; N]; 3],
        cell: [[0.0; N]; 2],
        off_center: [[0.0; N]; 2],
        pixel: [0; N],
        bits: [0; N],
    };

    /// Asks for the ranks of what the target saw there to be fetched.
    #[inline(always)]
    pub(crate) fn prefetch_ranks(&self, target: &CameraLayer) {
        // Neighboring lanes lie beside each other more often than not. Sixteen ranks fill a cache line, and most runs touch two.
        for lane in (0..N).step_by(8) {
            simd::prefetch(&target.ranks, self.pixel[lane] as usize);
        }
    }

    /// Lets lanes that are not `relevant` read what a relevant one reads, so that no memory is fetched for them.
    #[inline(always)]
    pub(crate) fn read_only(&mut self, relevant: &[u32; N]) {
        let mut pixel = 0;
        for i in 0..N {
            pixel = if relevant[i] == 0 { pixel } else { self.pixel[i] };
        }
        for i in 0..N {
            self.pixel[i] = if relevant[i] == 0 { pixel } else { self.pixel[i] };
        }
    }

    /// Asks for what the target saw there to be fetched.
    #[inline(always)]
    pub(crate) fn prefetch(&self, target: &CameraLayer) {
        for lane in (0..N).step_by(4) {
            let pixel = self.pixel[lane] as usize;
            let below = self.off_center[1][lane] > 0.0;
            let beside = if below { pixel + target.width } else { pixel.wrapping_sub(target.width) };
            simd::prefetch(&target.geometry, pixel);
            simd::prefetch(&target.geometry, beside);
        }
        for lane in (0..N).step_by(8) {
            simd::prefetch(&target.packed_colors, self.pixel[lane] as usize);
        }
    }
}

impl<const N: usize> PixelRun<N> {
    /// The samples of `layer` from `(column, row)` on for whose bit of `lanes` is set.
    #[inline(always)]
    pub(crate) fn new(layer: &CameraLayer, column: usize, row: usize, lanes: u32) -> Self {
        let position = (column, row);
        let level = layer.level.get(row * layer.width + column + lanes.trailing_zeros() as usize);
        Self::of_lanes(
            position,
            level.copied().unwrap_or(NO_SAMPLE),
            lanes,
            &lanes_of::<_, N>(&layer.geometry, layer.width, position, PackedGeometry::ABSENT),
            &lanes_of::<_, N>(&layer.packed_colors, layer.width, position, PackedColor::ABSENT),
            lanes_of::<_, N>(&layer.ranks, layer.width, position, ABSENT_RANK),
        )
    }

    #[inline(always)]
    fn of_lanes(
        (column, row): (usize, usize),
        level: SpanLevel,
        lanes: u32,
        geometry: &[PackedGeometry; N],
        packed_colors: &[PackedColor; N],
        rank: [Rank; N],
    ) -> Self {
        let mut block = Self {
            column,
            row,
            level,
            inverse_depth: [INVALID_INVERSE_DEPTH; N],
            normal: [[0.0; N]; 3],
            color: [[0; N]; 3],
            known: [0; N],
            rank,
        };
        for i in 0..N {
            let relevant = lanes >> i & 1 == 1;
            block.inverse_depth[i] = if relevant { geometry[i].inverse_depth } else { INVALID_INVERSE_DEPTH };
            let color = packed_colors[i].color();
            for axis in 0..3 {
                block.normal[axis][i] = geometry[i].normal_in_camera[axis];
                block.color[axis][i] = color[axis];
            }
            block.known[i] = u32::from(packed_colors[i].has_normal());
        }
        block
    }
}

impl PixelRun {
    /// The samples of a run.
    #[inline(always)]
    pub(crate) fn of_samples(samples: &RatedSamples, run: &SampleRun) -> Self {
        let SampleRun { row, nth, lanes, first } = *run;
        let geometry = spread(&samples.geometry[first..], lanes, PackedGeometry::ABSENT);
        let packed_colors = spread(&samples.packed_colors[first..], lanes, PackedColor::ABSENT);
        let ranks = spread(&samples.ranks[first..], lanes, ABSENT_RANK);
        Self::of_lanes((nth * LANES, row), samples.level, lanes, &geometry, &packed_colors, ranks)
    }
}

impl PixelRun<1> {
    /// The sample at an index.
    #[inline(always)]
    pub(crate) fn of_sample(samples: &RatedSamples, index: usize) -> Self {
        let pixel = samples.pixels[index] as usize;
        Self::of_lanes(
            (pixel % samples.width, pixel / samples.width),
            samples.level,
            1,
            &[samples.geometry[index]],
            &[samples.packed_colors[index]],
            [samples.ranks[index]],
        )
    }
}

/// The first of `values`, one for each of `lanes`; `nothing` in all others.
#[inline(always)]
fn spread<T: Copy>(values: &[T], lanes: u32, nothing: T) -> [T; LANES] {
    if lanes == (1 << LANES) - 1
        && let Some(all) = values.first_chunk()
    {
        return *all;
    }
    let mut spread = [nothing; LANES];
    let mut left = lanes;
    for &value in values {
        if left == 0 {
            break;
        }
        spread[left.trailing_zeros() as usize] = value;
        left &= left - 1;
    }
    spread
}

/// A run of pixels, and the layer of its camera, which need not hold their samples: what is known of the camera's noise counts.
#[derive(Clone, Copy)]
pub(crate) struct SourceRun<'a, const N: usize = LANES> {
    pub(crate) layer: &'a CameraLayer,
    pub(crate) run: &'a PixelRun<N>,
    /// Scalar values from the run's first sample on.
    values: &'a [f32],
    /// The lanes whose samples these values are of, in turn.
    lanes: u32,
}

impl<'a, const N: usize> SourceRun<'a, N> {
    /// A run of pixels of a layer.
    #[inline(always)]
    pub(crate) fn of_layer(layer: &'a CameraLayer, run: &'a PixelRun<N>) -> Self {
        let values = if layer.values.is_empty() {
            &[]
        } else {
            layer.values.starting_at(run.row * layer.width + run.column)
        };
        Self { layer, run, values, lanes: u32::MAX }
    }

    /// A run of samples, the first of which has this index, of the camera of a layer.
    #[inline(always)]
    pub(crate) fn of_samples(
        layer: &'a CameraLayer,
        run: &'a PixelRun<N>,
        samples: &'a RatedSamples,
        first: usize,
        lanes: u32,
    ) -> Self {
        Self { layer, run, values: samples.values.starting_at(first), lanes }
    }

    /// The values of the sample in a lane, one a channel; `None` where the lane holds none.
    pub(crate) fn values_of(&self, lane: usize, channels: usize) -> Option<&'a [f32]> {
        let before = (self.lanes & ((1 << lane) - 1)).count_ones() as usize;
        self.values.get(before * channels..(before + 1) * channels)
    }
}

/// Where the samples of a run lie in another camera, with that camera's layer.
#[derive(Clone, Copy)]
pub(crate) struct TargetRun<'a, const N: usize = LANES> {
    pub(crate) layer: &'a CameraLayer,
    pub(crate) reprojected: &'a ReprojectedRun<N>,
}

/// Where the samples of a block are in the target.
pub(crate) struct ReprojectedRun<const N: usize = LANES> {
    /// Points in target camera space, times the source's inverse depth.
    pub(crate) point: [[f32; N]; 3],
    /// Whole pixels.
    pub(crate) cell: [[f32; N]; 2],
    /// Position within the pixel, off its center, −0.5 to 0.5.
    pub(crate) off_center: [[f32; N]; 2],
    pub(crate) pixel: [u32; N],
    pub(crate) bits: [u32; N],
}

impl Registration {
    /// Carries the samples of a block.
    #[inline(always)]
    pub(crate) fn reproject<const N: usize>(
        &self,
        block: &PixelRun<N>,
        target_width: usize,
    ) -> ReprojectedRun<N> {
        if self.has_orthographic() {
            return self.reproject_orthographic(block, target_width);
        }
        let mut carried = ReprojectedRun::NOWHERE;
        let (column, t, lens) = (block.column as f32, self.translation, &self.target);
        let row = self.first_ray + self.per_row * block.row as f32;
        let width = target_width as u32;
        for i in 0..N {
            let (along, w) = (column + i as f32, block.inverse_depth[i]);
            let x = row.x + self.per_column.x * along + t.x * w;
            let y = row.y + self.per_column.y * along + t.y * w;
            let z = row.z + self.per_column.z * along + t.z * w;
            let reciprocal = 1.0 / z;
            let u = x * reciprocal * lens.focal[0] + lens.center[0];
            let v = y * reciprocal * lens.focal[1] + lens.center[1];
            let in_front = (w >= 0.0) & (z > 0.0);
            let in_view = in_front & (u >= 0.0) & (v >= 0.0) & (u < lens.size[0]) & (v < lens.size[1]);
            // What is outside, or is no number, goes to the first pixel.
            let (u, v) = if in_view { (u, v) } else { (0.5, 0.5) };
            let (left, top) = (u.floor(), v.floor());
            carried.point[0][i] = x;
            carried.point[1][i] = y;
            carried.point[2][i] = z;
            carried.cell[0][i] = left;
            carried.cell[1][i] = top;
            carried.off_center[0][i] = u - left - 0.5;
            carried.off_center[1][i] = v - top - 0.5;
            carried.pixel[i] = whole(top) * width + whole(left);
            carried.bits[i] = if in_front { IN_FRONT } else { 0 } | if in_view { IN_VIEW } else { 0 };
        }
        carried
    }

    /// The same where one of the cameras is orthographic. Apart, so that what is between cameras in perspective stays as fast as it is.
    #[cold]
    #[inline(never)]
    fn reproject_orthographic<const N: usize>(
        &self,
        block: &PixelRun<N>,
        target_width: usize,
    ) -> ReprojectedRun<N> {
        let mut carried = ReprojectedRun::NOWHERE;
        let lens = &self.target;
        let row = self.first_ray + self.per_row * block.row as f32;
        for i in 0..N {
            let w = block.inverse_depth[i];
            let point = self.point(row, block.column as f32 + i as f32, w);
            let in_front = (w >= 0.0) & (point.z > 0.0);
            let [x, y] = if self.source_is_orthographic & lens.is_orthographic {
                let place = row + self.per_column * (block.column as f32 + i as f32);
                let shift =
                    |axis: usize| if self.axes[2][axis] == 0.0 { 0.0 } else { self.axes[2][axis] / w };
                [place.x + shift(0), place.y + shift(1)]
            } else {
                let divisor = if lens.is_orthographic { w } else { point.z };
                [point.x / divisor, point.y / divisor]
            };
            let (u, v) = (x * lens.focal[0] + lens.center[0], y * lens.focal[1] + lens.center[1]);
            let in_view = in_front & (u >= 0.0) & (v >= 0.0) & (u < lens.size[0]) & (v < lens.size[1]);
            let (u, v) = if in_view { (u, v) } else { (0.5, 0.5) };
            let (left, top) = (u.floor(), v.floor());
            for axis in 0..3 {
                carried.point[axis][i] = point[axis];
            }
            carried.cell[0][i] = left;
            carried.cell[1][i] = top;
            carried.off_center[0][i] = u - left - 0.5;
            carried.off_center[1][i] = v - top - 0.5;
            carried.pixel[i] = whole(top) * target_width as u32 + whole(left);
            carried.bits[i] = if in_front { IN_FRONT } else { 0 } | if in_view { IN_VIEW } else { 0 };
        }
        carried
    }
}
