//! Whether colors change because patterns move over the picture, which is no noise.
//!
//! Purpose: a pattern that slides over a surface, as on a globe that spins, changes every pixel at the same depth, each by an
//! amount of its own, as noise does. Unlike noise it was there before, a little further on. A block of pixels has moved if
//! displacing the earlier picture, by whole pixels or along its slope by part of one, explains most of the change.
//!
//! Source: block matching by sums of absolute differences; for parts of a pixel Lucas and Kanade, *An Iterative Image
//! Registration Technique*, IJCAI 1981, without iterations. What differs: where a block went to does not matter.

use crate::capture::Frame;
use crate::color;

/// Columns and rows of a block.
const WIDTH: usize = 16;
const HEIGHT: usize = 4;

/// Patterns are searched for up to this many pixels away.
const REACH: usize = 4;

/// Blocks of a pair of frames that are looked at, about: plenty for a share.
const BLOCKS: usize = 1024;

/// A block has moved where displacing it leaves less than this share of its change. Noise always leaves more.
const LEFT_OVER: f32 = 0.5;

/// Whether most of the blocks whose color changes from one frame of a pair to the next have moved. What changes is looked at
/// where the surface is the same: where the relative inverse depths differ by no more than `limit`.
pub(crate) fn patterns_move(pairs: &[[&Frame; 2]], limit: f32) -> bool {
    let (mut changed, mut moved) = (0, 0);
    for &[before, after] in pairs {
        let (width, height) = after.size();
        let (across, down) = (places(width, WIDTH), places(height, HEIGHT));
        let step = (across * down / BLOCKS).max(1);
        for nth in (0..across * down).step_by(step) {
            let (left, top) = (REACH + nth % across * WIDTH, REACH + nth / across * HEIGHT);
            if changes([before, after], (left, top), limit) {
                changed += 1;
                moved += usize::from(has_moved([before, after], (left, top)));
            }
        }
    }
    2 * moved > changed
}

/// Blocks along a side of a picture that can be displaced.
fn places(side: usize, block: usize) -> usize {
    side.saturating_sub(2 * REACH) / block
}

/// Whether half of a block changes its color and no more.
fn changes([before, after]: [&Frame; 2], (left, top): (usize, usize), limit: f32) -> bool {
    let mut count = 0;
    for y in top..top + HEIGHT {
        let [old, new] = [before, after].map(|frame| &frame.color.row(y)[left..left + WIDTH]);
        let [far, near] = [before, after].map(|frame| &frame.inverse_depth.row(y)[left..left + WIDTH]);
        for i in 0..WIDTH {
            count += usize::from(old[i] != new[i] && is_same_surface([far[i], near[i]], limit));
        }
    }
    2 * count >= WIDTH * HEIGHT
}

/// Whether a block is that of the frame before, displaced.
fn has_moved([before, after]: [&Frame; 2], (left, top): (usize, usize)) -> bool {
    let mut around = [[0.0; WIDTH + 2 * REACH]; HEIGHT + 2 * REACH];
    let mut block = [[0.0; WIDTH]; HEIGHT];
    for (row, around) in around.iter_mut().enumerate() {
        read(before, (left - REACH, top + row - REACH), around);
    }
    for (row, block) in block.iter_mut().enumerate() {
        read(after, (left, top + row), block);
    }
    slides(&block, &around) || lies_elsewhere(&block, &around)
}

/// Brightness of pixels of a row, 8-bit sRGB steps.
fn read(frame: &Frame, (left, y): (usize, usize), to: &mut [f32]) {
    let table = color::steps_table();
    for (to, color) in to.iter_mut().zip(&frame.color.row(y)[left..]) {
        *to = color.iter().map(|channel| table[channel.to_bits() as usize]).sum::<f32>() / 3.0;
    }
}

type MotionBlock = [[f32; WIDTH]; HEIGHT];
type SearchArea = [[f32; WIDTH + 2 * REACH]; HEIGHT + 2 * REACH];

/// Whether one displacement along the slopes explains the change: the least squares fit of `change = u·slope_x + v·slope_y`.
fn slides(block: &MotionBlock, around: &SearchArea) -> bool {
    let (mut xx, mut xy, mut yy, mut xc, mut yc, mut cc) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (row, block) in block.iter().enumerate() {
        let (above, here, below) = (&around[row + REACH - 1], &around[row + REACH], &around[row + REACH + 1]);
        for (column, value) in block.iter().enumerate() {
            let at = column + REACH;
            let change = value - here[at];
            let (x, y) = (0.5 * (here[at + 1] - here[at - 1]), 0.5 * (below[at] - above[at]));
            xx += x * x;
            xy += x * y;
            yy += y * y;
            xc += x * change;
            yc += y * change;
            cc += change * change;
        }
    }
    let determinant = xx * yy - xy * xy;
    let explained = if determinant > 1e-3 * xx * yy {
        (yy * xc * xc - 2.0 * xy * xc * yc + xx * yc * yc) / determinant
    } else {
        // A pattern that runs one way does not show how it moves along itself.
        let along = |slope: f32, change: f32| if slope > 0.0 { change * change / slope } else { 0.0 };
        along(xx, xc).max(along(yy, yc))
    };
    cc - explained <= LEFT_OVER * cc
}

/// Whether displacing by whole pixels leaves little of the change.
fn lies_elsewhere(block: &MotionBlock, around: &SearchArea) -> bool {
    let left_over = |right: usize, below: usize| -> f32 {
        let mut sums = [0.0; WIDTH];
        for (row, block) in block.iter().enumerate() {
            let there = &around[row + below][right..right + WIDTH];
            for column in 0..WIDTH {
                sums[column] += (block[column] - there[column]).abs();
            }
        }
        sums.iter().sum()
    };
    let limit = LEFT_OVER * left_over(REACH, REACH);
    (0..=2 * REACH).any(|below| (0..=2 * REACH).any(|right| left_over(right, below) <= limit))
}

/// Whether a pixel shows one surface in two frames: inverse depths that are finite and differ by no more than `limit`, relative.
pub(crate) fn is_same_surface([before, after]: [f32; 2], limit: f32) -> bool {
    before.min(after) > 0.0 && (after - before).abs() <= limit * before.max(after)
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;
    use crate::grid::Grid;

    const SIZE: usize = 96;

    /// A picture of these brightnesses at one depth.
    fn frame(mut brightness: impl FnMut(f32, f32) -> f32) -> Frame {
        let pixels = (0..SIZE * SIZE).map(|i| brightness((i % SIZE) as f32, (i / SIZE) as f32));
        Frame {
            color: Grid::from_vec(SIZE, SIZE, pixels.map(|value| [f16::from_f32(value); 3]).collect()),
            inverse_depth: Grid::filled(SIZE, SIZE, 0.5),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: crate::capture::Values::default(),
        }
    }

    fn pattern(x: f32, y: f32) -> f32 {
        0.3 + 0.1 * (0.9 * x + 0.4 * (0.3 * y).sin()).sin() * (0.7 * y + 0.5 * (0.2 * x).cos()).cos()
    }

    fn random(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / (1 << 24) as f32 - 0.5
    }

    #[test]
    fn a_pattern_that_slides_by_a_part_of_a_pixel_or_by_several_is_told_from_noise() {
        let still = frame(pattern);
        for [across, down] in [[0.2, 0.0], [0.0, -0.4], [1.0, 0.3], [2.1, -1.9], [-3.6, 3.2]] {
            let moved = frame(|x, y| pattern(x - across, y - down));
            assert!(patterns_move(&[[&still, &moved]], 1e-3), "{across}, {down}");
        }
        for noise in [0.002, 0.02, 0.1] {
            let (mut before, mut after) = (1, 2);
            let before = frame(|x, y| pattern(x, y) + noise * random(&mut before));
            let after = frame(|x, y| pattern(x, y) + noise * random(&mut after));
            assert!(!patterns_move(&[[&before, &after]], 1e-3), "{noise}");
        }
    }

    #[test]
    fn blotches_of_noise_and_light_that_dims_are_no_pattern_that_moves() {
        let blotches = |seed: u32| {
            let mut state = seed;
            let half = SIZE / 2;
            let coarse: Vec<f32> = (0..half * half).map(|_| random(&mut state)).collect();
            frame(move |x, y| 0.3 + 0.05 * coarse[y as usize / 2 * half + x as usize / 2])
        };
        assert!(!patterns_move(&[[&blotches(1), &blotches(2)]], 1e-3));
        let dimmed = frame(|x, y| pattern(x, y) * (1.0 - 0.002 * x));
        assert!(!patterns_move(&[[&frame(pattern), &dimmed]], 1e-3));
        assert!(!patterns_move(&[[&dimmed, &dimmed]], 1e-3));
    }
}
