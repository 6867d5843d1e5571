//! The resolve stage: from keys and sums to a picture, block by block.
//!
//! The foreground of a frame is painted over the background by depth (the paper, §3.3). A pixel that no foreground reaches is
//! the background's own; elsewhere both are resolved together. Which pixels those are depends on the frame and the vantage
//! alone, so that painting over a cached background gives the very picture that painting everything anew gives.

mod gathered;
mod layers;
mod per_pixel;
mod strip;

pub(crate) use layers::{BlockSet, PaintedLayer, ResolveInput};

use rayon::prelude::*;

use super::gather::{BLOCK, GatherScratch, PictureRows, TOGETHER};
use super::vantage::{FrontColor, Picture};
use crate::error::Result;
use crate::settings::Kernel;
use crate::simd::{self, VectorLoop};
use gathered::gather_blocks;
use per_pixel::{ForegroundPixel, paint_over, show_nearest};
use strip::Strip;

/// Rows of blocks that one thread gathers at most, a column of them at a time.
const TALLEST: usize = 4;

/// Every thread has so many parts of the picture at least, so that none waits long for another.
const PARTS_A_THREAD: usize = 4;

/// Resolves the blocks of `which` into `picture`; others are left as they are.
pub(crate) fn resolve(input: &ResolveInput<'_>, which: &BlockSet, picture: &mut Picture) -> Result<()> {
    let width = input.stage.width;
    // Neighboring blocks read the same tiles of the cameras, those below as well as those beside.
    let parts = PARTS_A_THREAD * rayon::current_num_threads();
    let tallest = (input.height() / (BLOCK * parts)).clamp(1, TALLEST);
    let tall = if input.views.is_some() { 1 << tallest.ilog2() } else { 1 };
    let (width, rows) = (width / input.subpixels, BLOCK / input.subpixels);
    let strip = tall * rows * width;
    // As many chunks as of the other planes, if these are empty.
    let strips = picture.image.len().div_ceil(strip);
    let mut fronts: Vec<&mut [FrontColor]> = picture.fronts.chunks_mut(strip).collect();
    fronts.resize_with(strips, Default::default);
    let mut coverage: Vec<&mut [f32]> = picture.coverage.chunks_mut(strip).collect();
    coverage.resize_with(strips, Default::default);
    let color = picture.color.as_mut_slice().par_chunks_mut(strip);
    let depth = picture.inverse_depth.as_mut_slice().par_chunks_mut(strip);
    let image = picture.image.as_mut_slice().par_chunks_mut(strip);
    let cameras = input.stage.frame.set.cameras.len();
    color.zip(depth).zip(image).zip(fronts).zip(coverage).enumerate().try_for_each_init(
        || input.scratches.borrow(cameras),
        |scratch, (nth, ((((color, inverse_depth), image), fronts), coverage))| {
            input.stage.job.check()?;
            let row = rows * width;
            let rows = color.chunks_mut(row).zip(inverse_depth.chunks_mut(row)).zip(image.chunks_mut(row));
            let (mut fronts, mut coverage) = (fronts.chunks_mut(row), coverage.chunks_mut(row));
            let strips = rows.enumerate().map(|(below, ((color, inverse_depth), image))| Strip {
                input,
                row: nth * tall + below,
                rows: PictureRows {
                    width,
                    subpixels: input.subpixels,
                    color,
                    inverse_depth,
                    image,
                    fronts: fronts.next().unwrap_or_default(),
                    coverage: coverage.next().unwrap_or_default(),
                },
            });
            simd::run(StripGroup { input, which, scratch: scratch.get(cameras), strips: strips.collect() });
            Ok(())
        },
    )
}

/// Rows of blocks that one thread resolves together.
struct StripGroup<'a> {
    input: &'a ResolveInput<'a>,
    which: &'a BlockSet,
    scratch: &'a mut GatherScratch,
    strips: Vec<Strip<'a>>,
}

impl VectorLoop for StripGroup<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let input = self.input;
        if input.stage.kernel == Kernel::Point
            && input.background_picture.is_none()
            && input.stage.frame.tile_count() > 0
        {
            for strip in &mut self.strips {
                show_nearest(strip, self.which);
            }
            return;
        }
        let columns = input.stage.width.div_ceil(BLOCK);
        if input.views.is_some() {
            let wide = TOGETHER / self.strips.len();
            for first in (0..columns).step_by(wide) {
                let columns = first..(first + wide).min(columns);
                gather_blocks(&mut self.strips, columns, self.which, self.scratch);
            }
            return;
        }
        let mut shown = Vec::new();
        for column in 0..columns {
            for strip in self.strips.iter_mut().filter(|strip| self.which.contains(column, strip.row)) {
                resolve_block(strip, column, &mut shown);
            }
        }
    }
}

/// Resolves the block in a column of blocks, without looking colors up in cameras.
#[inline(always)]
fn resolve_block(strip: &mut Strip<'_>, column: usize, shown: &mut Vec<ForegroundPixel>) {
    let (input, block) = (strip.input, strip.block(column));
    if let (Some(foreground), Some(background)) = (input.foreground, input.background_picture) {
        strip.copy(block, background);
        paint_over(strip, block, foreground, shown);
    } else {
        strip.blend(block);
    }
}
