//! A row of blocks that is resolved, and the ways to resolve one of its blocks as a whole.

use super::layers::ResolveInput;
use crate::render::gather::{BLOCK, BlockOrigin, PictureRows};
use crate::render::vantage::Picture;

/// A row of blocks.
pub(super) struct Strip<'a> {
    pub(super) input: &'a ResolveInput<'a>,
    /// Index among the rows of blocks.
    pub(super) row: usize,
    pub(super) rows: PictureRows<'a>,
}

impl Strip<'_> {
    /// The block in a column of blocks.
    #[inline(always)]
    pub(super) fn block(&self, column: usize) -> BlockOrigin {
        BlockOrigin { left: column * BLOCK, top: self.row * BLOCK }
    }

    /// Copies one block from a picture.
    #[inline(always)]
    pub(super) fn copy(&mut self, block: BlockOrigin, from: &Picture) {
        let (columns, rows) = self.rows.extent(block.left);
        let (width, subpixels) = (self.rows.width, self.rows.subpixels);
        let [left, top, columns, rows] =
            [block.left, block.top, columns, rows].map(|pixels| pixels / subpixels);
        for row in 0..rows {
            let to = row * width + left..row * width + left + columns;
            let start = (top + row) * width + left;
            let source = start..start + columns;
            put(&mut self.rows.color[to.clone()], &from.color.as_slice()[source.clone()]);
            put(&mut self.rows.inverse_depth[to.clone()], &from.inverse_depth.as_slice()[source.clone()]);
            put(&mut self.rows.image[to.clone()], &from.image.as_slice()[source.clone()]);
            if !self.rows.fronts.is_empty() {
                put(&mut self.rows.fronts[to.clone()], &from.fronts[source.clone()]);
            }
            if !self.rows.coverage.is_empty() {
                put(&mut self.rows.coverage[to], &from.coverage[source]);
            }
        }
    }

    /// Gives each pixel of one block the blended color of its nearest surface.
    #[inline(always)]
    pub(super) fn blend(&mut self, block: BlockOrigin) {
        let (columns, rows) = self.rows.extent(block.left);
        let (input, width) = (self.input, self.rows.width);
        for row in 0..rows {
            for column in 0..columns {
                let pixel = (block.top + row) * width + block.left + column;
                let key = input.key(pixel);
                let color = if key == 0 { [0.0; 3] } else { input.blended(pixel, key) };
                self.rows.set(input.stage.frame, row * width + block.left + column, key, color);
            }
        }
    }
}

/// Copies as many values as both slices have. The usual case of sixteen takes neither a call nor a loop.
#[inline(always)]
pub(super) fn put<T: Copy>(to: &mut [T], from: &[T]) {
    if let (Some(to), Some(from)) = (to.first_chunk_mut::<BLOCK>(), from.first_chunk::<BLOCK>()) {
        *to = *from;
    } else {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    }
}
