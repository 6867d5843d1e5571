//! What a hole pixel sees across its own hole: the first painted pixel in each of eight directions.
//!
//! ```text
//!     forward    1 2 3        backward is the same sweep over the picture turned by 180°:
//!                0 p 0'       0' to 3' lie opposite of 0 to 3
//!                3'2'1'
//! ```
//!
//! Steps are counted in one sweep per half of the directions, in bands of rows that do not wait for each other; a ray that
//! leaves its band goes on from the last row of the one before, which knows what lies beyond.

use rayon::prelude::*;

use crate::render::vantage::NO_IMAGE;

/// Pixels that are passed over at once where none of them is a hole.
const RUN: usize = 32;

/// Rows of a band.
const BAND: usize = 64;

/// No painted pixel before the band or, in the last row of a band, the picture ends; none within 65,534 steps.
const NONE: u16 = u16::MAX;

/// Steps to the first painted pixel to the left, up left, up, and up right; 0 in painted pixels.
type Steps = [u16; 4];

/// Columns that one step in each direction goes to the right.
const COLUMNS: [isize; 4] = [-1, -1, 0, 1];

/// What a hole pixel sees, direction by direction; direction `i + 4` is opposite of `i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HoleNeighbors {
    /// Index of the painted pixel, row-major; 0 where there is none.
    pub(super) pixel: [usize; 8],
    /// Distance to it; infinite where there is none.
    pub(super) distance_px: [f32; 8],
}

/// Rays from every hole pixel; none before they are cast.
#[derive(Debug, Default)]
pub(super) struct HoleRays {
    size: (usize, usize),
    forward: Vec<Steps>,
    backward: Vec<Steps>,
}

impl HoleRays {
    /// Casts all rays over a picture of `size` whose holes hold [`NO_IMAGE`].
    pub(super) fn cast(&mut self, image: &[u32], size: (usize, usize)) {
        let last = image.len() - 1;
        let Self { forward, backward, .. } = self;
        for steps in [&mut *forward, &mut *backward] {
            steps.resize(image.len(), [0; 4]);
        }
        rayon::join(
            || sweep(size.0, forward, |pixel| image[pixel] == NO_IMAGE),
            || sweep(size.0, backward, |pixel| image[last - pixel] == NO_IMAGE),
        );
        self.size = size;
    }

    /// What the hole pixel `(x, y)` sees.
    pub(super) fn neighbors(&self, (x, y): (usize, usize)) -> HoleNeighbors {
        let (width, height) = self.size;
        let last = width * height - 1;
        let turned = (width - 1 - x, height - 1 - y);
        let mut seen = HoleNeighbors { pixel: [0; 8], distance_px: [f32::INFINITY; 8] };
        for direction in 0..8 {
            let is_turned = direction >= 4;
            let (steps, (x, y)) = if is_turned { (&self.backward, turned) } else { (&self.forward, (x, y)) };
            let within = steps[y * width + x][direction % 4];
            let count = steps_ahead(within, steps, width, (x, y), direction % 4);
            if count != NONE {
                // Pixels to go back, row-major, for each step.
                let stride = [1, width + 1, width, width - 1][direction % 4];
                let length = [1.0, std::f32::consts::SQRT_2][direction % 2];
                let pixel = y * width + x - count as usize * stride;
                seen.pixel[direction] = if is_turned { last - pixel } else { pixel };
                seen.distance_px[direction] = f32::from(count) * length;
            }
        }
        seen
    }
}

/// Counts the steps of one half of the directions.
fn sweep(width: usize, steps: &mut [Steps], is_hole: impl Fn(usize) -> bool + Sync) {
    let count = steps.len();
    steps.par_chunks_mut(BAND * width).enumerate().for_each(|(band, steps)| {
        let first = band * BAND * width;
        for start in (0..steps.len()).step_by(RUN) {
            let run = start..(start + RUN).min(steps.len());
            steps[run.clone()].fill([0; 4]);
            if !run.clone().fold(false, |any, local| any | is_hole(first + local)) {
                continue;
            }
            for local in run.filter(|local| is_hole(first + *local)) {
                let x = local % width;
                let has = [x > 0, x > 0 && local >= width, local >= width, x + 1 < width && local >= width];
                // Wrapping, as the first row's upper neighbors are never looked at.
                let above = local.wrapping_sub(width);
                let neighbors = [local.wrapping_sub(1), above.wrapping_sub(1), above, above.wrapping_add(1)];
                for direction in 0..4 {
                    let next = if has[direction] { steps[neighbors[direction]][direction] } else { NONE };
                    steps[local][direction] = next.saturating_add(1);
                }
            }
        }
    });
    for last in (2 * BAND - 1..count / width).step_by(BAND) {
        for x in 0..width {
            let pixel = last * width + x;
            steps[pixel] = [0, 1, 2, 3].map(|direction| {
                let here = steps[pixel][direction];
                let beyond = (here == NONE && direction > 0)
                    .then(|| row_before_band((x, last), width, direction))
                    .flatten()
                    .map(|(x, y)| steps[y * width + x][direction].saturating_add(BAND as u16));
                beyond.unwrap_or(here)
            });
        }
    }
}

/// Where a ray enters the band before its own; `None` where it leaves the picture first.
fn row_before_band((x, y): (usize, usize), width: usize, direction: usize) -> Option<(usize, usize)> {
    let rows = y % BAND + 1;
    let x = x.checked_add_signed(COLUMNS[direction] * rows as isize).filter(|&x| x < width)?;
    Some((x, y.checked_sub(rows)?))
}

/// Steps to the end of one ray: `within` its band, and those of the band before where it goes on there.
#[inline]
fn steps_ahead(within: u16, steps: &[Steps], width: usize, from: (usize, usize), direction: usize) -> u16 {
    if within != NONE || direction == 0 {
        return within;
    }
    let rows = (from.1 % BAND + 1) as u16;
    row_before_band(from, width, direction)
        .map_or(NONE, |(x, y)| steps[y * width + x][direction].saturating_add(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The plain search, one step after another.
    fn step_through(
        image: &[u32],
        (width, height): (usize, usize),
        from: (usize, usize),
        step: (i32, i32),
    ) -> Option<(usize, f32)> {
        let mut taken = 0;
        loop {
            taken += 1;
            let x = usize::try_from(from.0 as i32 + taken * step.0).ok().filter(|x| *x < width)?;
            let y = usize::try_from(from.1 as i32 + taken * step.1).ok().filter(|y| *y < height)?;
            if image[y * width + x] != NO_IMAGE {
                let length = if step.0 != 0 && step.1 != 0 { std::f32::consts::SQRT_2 } else { 1.0 };
                return Some((y * width + x, taken as f32 * length));
            }
        }
    }

    #[test]
    fn rays_find_what_single_steps_find_within_and_across_bands() {
        for (width, height, every) in [(1, 1, 2), (1, 200, 41), (90, 1, 17), (37, 150, 300), (70, 131, 5)] {
            let image: Vec<u32> = (0..width * height)
                .map(|i| if (i * 7919 + i / 3) % every == every - 1 { 3 } else { NO_IMAGE })
                .collect();
            let mut rays = HoleRays::default();
            rays.cast(&vec![NO_IMAGE; 200 * 200], (200, 200));
            rays.cast(&image, (width, height));
            for pixel in (0..image.len()).filter(|&pixel| image[pixel] == NO_IMAGE) {
                let from = (pixel % width, pixel / width);
                let neighbors = rays.neighbors(from);
                let seen = |direction: usize| {
                    let found = neighbors.distance_px[direction].is_finite();
                    found.then_some((neighbors.pixel[direction], neighbors.distance_px[direction]))
                };
                for (direction, (x, y)) in [(-1, 0), (-1, -1), (0, -1), (1, -1)].into_iter().enumerate() {
                    assert_eq!(
                        seen(direction),
                        step_through(&image, (width, height), from, (x, y)),
                        "{from:?}"
                    );
                    assert_eq!(
                        seen(direction + 4),
                        step_through(&image, (width, height), from, (-x, -y)),
                        "{from:?}"
                    );
                }
            }
        }
    }
}
