//! Blocks that are gathered together: each is decided alone, and the colors of all are looked up at once.

use std::ops::Range;

use super::layers::BlockSet;
use super::strip::Strip;
use crate::render::gather::{BLOCK, GatherScratch, TOGETHER};

/// Gathers the blocks of `which` in some columns of strips, at most [`TOGETHER`] blocks. Pixels near a visible foreground are gathered among
/// all samples, others among those of the background alone, which is what the background's picture shows there.
#[inline(always)]
pub(super) fn gather_blocks(
    strips: &mut [Strip<'_>],
    columns: Range<usize>,
    which: &BlockSet,
    scratch: &mut GatherScratch,
) {
    let Some((input, views)) = strips.first().and_then(|strip| Some((strip.input, strip.input.views?)))
    else {
        return;
    };
    let mut near = [[0; BLOCK]; TOGETHER];
    // One loop for both, because all code in it is inlined.
    for (nth, views) in views.into_iter().enumerate() {
        let among_all = nth == 1;
        scratch.begin();
        let (mut decided, mut count) = ([0; TOGETHER], 0);
        let down = strips.len();
        let blocks = columns.clone().flat_map(|column| (0..down).map(move |at| (column, at)));
        for ((column, at), near) in blocks.zip(&mut near) {
            let strip = &mut strips[at];
            if !which.contains(column, strip.row) {
                continue;
            }
            let block = strip.block(column);
            if let Some(foreground) = input.foreground.filter(|_| !among_all) {
                *near = input.near_foreground(block, foreground);
            }
            let which = if among_all { *near } else { near.map(|near| !near) };
            if which == [0; BLOCK] {
                continue;
            }
            if !among_all && let Some(background) = input.background_picture {
                strip.copy(block, background);
                continue;
            }
            input.load(block, input.foreground.filter(|_| among_all), &mut scratch.patch);
            scratch.decide(views, nth, &which, &mut strip.rows);
            (decided[count], count) = (at, count + 1);
        }
        scratch.find_colors(views, nth);
        for (nth, strip) in decided[..count].iter().enumerate() {
            scratch.add_colors(nth, input.stage.frame, &mut strips[*strip].rows);
        }
    }
}
