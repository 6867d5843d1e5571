//! The samples of one image as streams of bytes, each of one kind of number.
//!
//! ```text
//! for each tile, row-major:  PLACES    tiles skipped since the last one, as a variable-length number
//!                            MASKS     0: every pixel holds a sample; 1: sixteen rows of two bytes, each XOR the row above
//!                            DOUBTFUL  of images with doubtful samples: 0: none; 1: sixteen rows likewise
//! for each of its samples:   DEPTH     inverse depth less its prediction, one byte; −128: in ESCAPES, as a variable-length number
//!                            GREEN     green less its prediction, one byte
//!                            RED, BLUE the same, less that of green
//! ```
//!
//! `DEPTH`, `GREEN`, `RED` and `BLUE` are several streams: which one a byte goes to depends on what is decoded already, so that bytes of
//! like spread are together. Every neighbor within the image counts, across the borders of tiles, if its tile comes before.
//!
//! Predictions of numbers from neighbors that are decoded already.
//!
//! Source: for colors the median edge detector of LOCO-I (Weinberger et al., *The LOCO-I Lossless Image Compression Algorithm*, IEEE
//! TIP 2000). Inverse depth is linear in the pixels of a plane, so that `left + above − corner` is exact on planes, across whose
//! edges the detector would clip it.

use crate::color::srgb8_from_linear;
use crate::samples::{SampleImage, SampleTile, TILE};
use crate::store::push_varint;

pub(super) const PLACES: usize = 0;
pub(super) const MASKS: usize = 1;
pub(super) const DOUBTFUL: usize = 2;
/// Smooth surfaces, then all else.
pub(super) const DEPTH: usize = 3;
pub(super) const ESCAPES: usize = 5;
pub(super) const GREEN: usize = 6;
pub(super) const RED: usize = 10;
pub(super) const BLUE: usize = 13;
/// How many there are.
pub(super) const STREAMS: usize = 16;

/// The streams of some images, one image after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Streams(pub(super) [Vec<u8>; STREAMS]);

/// The byte of `DEPTH` for what is in `ESCAPES`.
const ESCAPE: u8 = 0x80;

/// The pixels of an image that are coded already, between missing ones on all sides.
struct Plane {
    stride: usize,
    depths: Vec<i32>,
    colors: Vec<[u8; 3]>,
}

/// Missing pixels on each side: predictions look two pixels back.
const BORDER: usize = 2;

impl Plane {
    fn of(image: &SampleImage) -> Self {
        let last = |place: fn(&SampleTile) -> u16| image.tiles.iter().map(place).max().map_or(0, usize::from);
        let (columns, rows) = (last(|tile| tile.tile_x) + 1, last(|tile| tile.tile_y) + 1);
        let stride = columns * TILE + 2 * BORDER;
        let pixels = stride * (rows * TILE + 2 * BORDER);
        Self { stride, depths: vec![MISSING; pixels], colors: vec![[0; 3]; pixels] }
    }

    fn at(&self, tile: &SampleTile, column: usize, row: usize) -> usize {
        let (x, y) = (usize::from(tile.tile_x) * TILE + column, usize::from(tile.tile_y) * TILE + row);
        (y + BORDER) * self.stride + x + BORDER
    }

    fn depths_around(&self, at: usize, before: i32) -> DepthsAround {
        let (w, stride) = (&self.depths, self.stride);
        DepthsAround {
            left: w[at - 1],
            above: w[at - stride],
            corner: w[at - stride - 1],
            left2: w[at - 2],
            above2: w[at - 2 * stride],
            before,
        }
    }

    /// The predicted color of a pixel, and the context of its green.
    fn predicted_color(&self, at: usize, predictor: u8, before: [u8; 3]) -> ([u8; 3], usize) {
        let stride = self.stride;
        let [left, above, corner, right] = [at - 1, at - stride, at - stride - 1, at - stride + 1]
            .map(|at| (self.depths[at] != MISSING).then(|| self.colors[at].map(i32::from)));
        let (Some(left), Some(above)) = (left, above) else {
            let color = left.or(above).map_or(before, |color| color.map(|channel| channel as u8));
            return (color, 3);
        };
        let Some(corner) = corner else {
            return ([0, 1, 2].map(|c| ((left[c] + above[c] + 1) >> 1) as u8), 3);
        };
        let beyond = right.map_or(0, |right| (right[1] - above[1]).abs());
        let differences = (left[1] - corner[1]).abs() + (above[1] - corner[1]).abs() + beyond;
        let color = [0, 1, 2].map(|c| predicted_channel(predictor, left[c], above[c], corner[c]) as u8);
        (color, activity_context(differences))
    }
}

/// Appends an image, its inverse depths without their lowest `shift` bits, rounded. Gives the predictor of its colors, which the
/// reader needs.
pub(super) fn encode(streams: &mut Streams, image: &SampleImage, columns: usize, shift: u32) -> u8 {
    let colors: Vec<[u8; 3]> =
        image.color.iter().map(|color| color.map(|channel| srgb8_from_linear(channel.to_f32()))).collect();
    let depths: Vec<i32> = image.inverse_depths().iter().map(|depth| quantized(*depth, shift)).collect();
    let numbers = Numbers { depths: &depths, colors: &colors };
    let errors = (0..PREDICTORS).map(|predictor| {
        let mut tried = Streams::default();
        encode_with(&mut tried, image, columns, &numbers, predictor)
    });
    let best = errors.enumerate().min_by_key(|(_, error)| *error).map_or(0, |(predictor, _)| predictor as u8);
    encode_with(streams, image, columns, &numbers, best);
    best
}

/// What is coded of each sample of an image, in storage order.
struct Numbers<'a> {
    depths: &'a [i32],
    colors: &'a [[u8; 3]],
}

/// Inverse depth, in units of its lowest bit that is kept.
pub(super) fn quantized(inverse_depth: f32, shift: u32) -> i32 {
    let half = if shift == 0 { 0 } else { 1_u32 << (shift - 1) };
    let largest = f32::MAX.to_bits();
    ((inverse_depth.to_bits().min(largest - half) + half) >> shift) as i32
}

/// Gives the sum of the residuals of green.
fn encode_with(
    streams: &mut Streams,
    image: &SampleImage,
    columns: usize,
    numbers: &Numbers<'_>,
    predictor: u8,
) -> u64 {
    let Numbers { depths, colors } = *numbers;
    let mut plane = Plane::of(image);
    let (mut next_place, mut depth_before, mut color_before, mut error) = (0, 0, [0; 3], 0);
    for (index, tile) in image.tiles.iter().enumerate() {
        let place = usize::from(tile.tile_y) * columns + usize::from(tile.tile_x);
        push_varint(&mut streams.0[PLACES], (place - next_place) as u64);
        next_place = place + 1;
        push_masks(&mut streams.0[MASKS], &tile.rows, u16::MAX);
        if !image.doubtful.is_empty() {
            push_masks(&mut streams.0[DOUBTFUL], image.doubtful_rows(index).unwrap_or(&[0; TILE]), 0);
        }
        let mut nth = tile.first as usize;
        for (row, &mask) in tile.rows.iter().enumerate() {
            for column in (0..TILE).filter(|column| mask >> column & 1 == 1) {
                let at = plane.at(tile, column, row);
                let around = plane.depths_around(at, depth_before);
                push_depth(streams, &around, depths[nth]);
                let (predicted, context) = plane.predicted_color(at, predictor, color_before);
                error += push_color(streams, colors[nth], predicted, context);
                (depth_before, color_before) = (depths[nth], colors[nth]);
                (plane.depths[at], plane.colors[at]) = (depth_before, color_before);
                nth += 1;
            }
        }
    }
    error
}

fn push_depth(streams: &mut Streams, around: &DepthsAround, depth: i32) {
    let (predicted, is_smooth) = around.predicted();
    let residual = depth - predicted;
    let fits = (-127..=127).contains(&residual);
    streams.0[DEPTH + usize::from(!is_smooth)].push(if fits { residual as i8 as u8 } else { ESCAPE });
    if !fits {
        // The sign is the lowest bit.
        push_varint(&mut streams.0[ESCAPES], u64::from(((residual << 1) ^ (residual >> 31)) as u32));
    }
}

/// Gives the magnitude of the residual of green.
fn push_color(streams: &mut Streams, color: [u8; 3], predicted: [u8; 3], context: usize) -> u64 {
    let [red, green, blue] = [0, 1, 2].map(|c| color[c].wrapping_sub(predicted[c]));
    let by_green = green_context(green);
    streams.0[GREEN + context].push(green);
    streams.0[RED + by_green].push(red.wrapping_sub(green));
    streams.0[BLUE + by_green].push(blue.wrapping_sub(green));
    u64::from((green as i8).unsigned_abs())
}

/// Sixteen rows, or one byte where all of them are `usual`.
fn push_masks(stream: &mut Vec<u8>, rows: &[u16; TILE], usual: u16) {
    if rows.iter().all(|row| *row == usual) {
        stream.push(0);
        return;
    }
    stream.push(1);
    let mut above = 0;
    for row in rows {
        stream.extend((row ^ above).to_le_bytes());
        above = *row;
    }
}

/// A pixel without a sample, or beyond what is decoded.
pub(super) const MISSING: i32 = -1;

/// Neighbors whose depths differ by more quanta than this are of different surfaces.
const EDGE: i32 = 256;

/// Neighbors whose depths differ by at most this many quanta are of a smooth surface.
const SMOOTH: i32 = 12;

/// Quantized inverse depths around a pixel; [`MISSING`] where there is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthsAround {
    pub(super) left: i32,
    pub(super) above: i32,
    pub(super) corner: i32,
    /// Two to the left.
    pub(super) left2: i32,
    /// Two above.
    pub(super) above2: i32,
    /// The sample before in storage order, 0 at first.
    pub(super) before: i32,
}

impl DepthsAround {
    /// The prediction, never negative, and whether it is of a smooth surface.
    pub(super) fn predicted(&self) -> (i32, bool) {
        let Self { left, above, corner, left2, above2, before } = *self;
        if left == MISSING && above == MISSING {
            return (before, false);
        }
        if left == MISSING {
            return (continued(above, above2), false);
        }
        if above == MISSING {
            return (continued(left, left2), false);
        }
        if corner == MISSING {
            return (left, false);
        }
        if left == 0 || above == 0 {
            return (if corner == 0 { left.max(above) } else { 0 }, left == above);
        }
        let (down, across) = ((left - corner).abs(), (above - corner).abs());
        if down > EDGE && across > EDGE {
            return (left, false);
        }
        ((left + above - corner).max(0), down <= SMOOTH && across <= SMOOTH)
    }
}

/// What follows `near` and, before it, `far`.
fn continued(near: i32, far: i32) -> i32 {
    if near == 0 || far == MISSING || (near - far).abs() > EDGE { near } else { (2 * near - far).max(0) }
}

/// How colors are predicted, chosen for each image.
pub(super) const PREDICTORS: u8 = 2;

/// One channel of the colors around a pixel that has both neighbors and the corner.
pub(super) fn predicted_channel(predictor: u8, left: i32, above: i32, corner: i32) -> i32 {
    if predictor == 0 {
        let plane = left + above - corner;
        return plane.clamp(left.min(above), left.max(above));
    }
    // Averages the noise of both, which the detector does not.
    ((3 * (left + above) - 2 * corner + 2) >> 2).clamp(0, 255)
}

/// Which of four streams a green residual goes to, by how much the greens around differ.
pub(super) fn activity_context(differences: i32) -> usize {
    match differences {
        ..=3 => 0,
        4..=10 => 1,
        11..=28 => 2,
        _ => 3,
    }
}

/// Which of three streams the residuals of red and blue go to, by that of green.
pub(super) fn green_context(residual: u8) -> usize {
    match (residual as i8).unsigned_abs() {
        0..=1 => 0,
        2..=6 => 1,
        _ => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(left: i32, above: i32, corner: i32) -> DepthsAround {
        DepthsAround { left, above, corner, left2: MISSING, above2: MISSING, before: 77 }
    }

    #[test]
    fn planes_are_predicted_exactly_and_edges_from_their_own_side() {
        assert_eq!(around(1005, 1003, 1000).predicted(), (1008, true));
        // Left and corner are of the far surface, above is of the near one.
        assert_eq!(around(1000, 5000, 1000).predicted().0, 5000);
        assert_eq!(around(5000, 1000, 9000).predicted().0, 5000);
        assert_eq!(around(MISSING, MISSING, 3).predicted(), (77, false));
    }

    #[test]
    fn what_lies_between_sky_and_surface_is_never_in_the_air() {
        assert_eq!(around(0, 0, 0).predicted(), (0, true));
        assert_eq!(around(0, 900, 0).predicted().0, 900);
        assert_eq!(around(0, 900, 905).predicted().0, 0);
        assert_eq!(around(0, MISSING, MISSING).predicted().0, 0);
    }
}
