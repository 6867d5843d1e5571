//! A sample image in the words that shaders read; the layout is drawn in `shaders/common/samples.wgsl`.

use std::ops::Range;

use bytemuck::Zeroable;

use super::layout::{GpuPiece, GpuTile};
use crate::render::input::samples_above;
use crate::samples::{SampleImage, TILE};

const TILE_WORDS: u32 = (size_of::<GpuTile>() / 4) as u32;

/// Words of a mask of a tile's pixels, as `MASK_WORDS` in `samples.wgsl`.
pub(super) const MASK_WORDS: u32 = (size_of::<[u16; TILE]>() / 4) as u32;

/// A run of tiles of one image and the parts of its planes that belong to them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    tiles: Range<usize>,
    samples: Range<usize>,
    high: Range<usize>,
    /// Whether any sample of the image is doubtful.
    has_doubtful: bool,
}

impl Piece {
    /// Cuts an image into pieces of at most `max_words`, or of one tile where even that is more.
    pub(super) fn cut(image: &SampleImage, max_words: u32) -> Vec<Self> {
        let (depths, total) = (image.depth.tiles(), image.tiles.len());
        let end = |tile: usize| {
            if tile < total {
                (image.tiles[tile].first as usize, depths[tile].first_high as usize)
            } else {
                (image.len(), image.depth.high().len())
            }
        };
        let mut pieces = Vec::new();
        let mut start = 0;
        while start < total {
            let piece = |stop: usize| Self {
                tiles: start..stop,
                samples: end(start).0..end(stop).0,
                high: end(start).1..end(stop).1,
                has_doubtful: !image.doubtful.is_empty(),
            };
            let mut stop = start + 1;
            while stop < total && piece(stop + 1).words() <= max_words {
                stop += 1;
            }
            pieces.push(piece(stop));
            start = stop;
        }
        pieces
    }

    /// Words of each plane: tiles, low, high, color, doubtful.
    fn plane_words(&self) -> [u32; 5] {
        [
            self.tiles.len() as u32 * TILE_WORDS,
            self.samples.len().div_ceil(2) as u32,
            self.high.len().div_ceil(4) as u32,
            (3 * self.samples.len()).div_ceil(2) as u32,
            if self.has_doubtful { self.tiles.len() as u32 * MASK_WORDS } else { 0 },
        ]
    }

    /// Words in all.
    pub(super) fn words(&self) -> u32 {
        self.plane_words().iter().sum()
    }

    /// The piece at word `at` of a page, to be completed by camera and image; tiles count from the first of the image.
    pub(super) fn place(&self, page: u32, at: u32) -> GpuPiece {
        let [tiles, low, high, color, _] = self.plane_words();
        let color_at = at + tiles + low + high;
        GpuPiece {
            first_tile: self.tiles.start as u32,
            page,
            tiles_at: at,
            low_at: at + tiles,
            high_at: at + tiles + low,
            color_at,
            doubtful_at: if self.has_doubtful { color_at + color } else { 0 },
            ..GpuPiece::zeroed()
        }
    }

    /// Uploads the piece to its place in `page`.
    pub(super) fn write(
        &self,
        image: &SampleImage,
        queue: &wgpu::Queue,
        page: &wgpu::Buffer,
        place: &GpuPiece,
    ) {
        let tiles: Vec<GpuTile> = self
            .tiles
            .clone()
            .map(|index| {
                let (tile, depth) = (&image.tiles[index], image.depth.tiles()[index]);
                GpuTile {
                    place: [tile.tile_x, tile.tile_y],
                    first: tile.first - self.samples.start as u32,
                    farthest: depth.farthest,
                    nearest: depth.nearest,
                    first_high: depth.first_high - self.high.start as u32,
                    before: samples_above(&tile.rows),
                    rows: tile.rows,
                }
            })
            .collect();
        let color = &image.color[self.samples.clone()];
        let doubtful: Vec<[u16; TILE]> = if self.has_doubtful {
            self.tiles.clone().map(|tile| image.doubtful_rows(tile).copied().unwrap_or_default()).collect()
        } else {
            Vec::new()
        };
        let planes: [(u32, &[u8]); 5] = [
            (place.tiles_at, bytemuck::cast_slice(&tiles)),
            (place.low_at, bytemuck::cast_slice(&image.depth.low()[self.samples.clone()])),
            (place.high_at, &image.depth.high()[self.high.clone()]),
            (place.color_at, bytemuck::cast_slice(color)),
            (place.doubtful_at, bytemuck::cast_slice(&doubtful)),
        ];
        for (at, bytes) in planes {
            write_words(queue, page, u64::from(at) * 4, bytes);
        }
    }
}

/// Writes bytes, and zeros up to a whole word.
fn write_words(queue: &wgpu::Queue, buffer: &wgpu::Buffer, at: u64, bytes: &[u8]) {
    let (whole, rest) = bytes.split_at(bytes.len() & !3);
    if !whole.is_empty() {
        queue.write_buffer(buffer, at, whole);
    }
    if !rest.is_empty() {
        let mut last = [0; 4];
        last[..rest.len()].copy_from_slice(rest);
        queue.write_buffer(buffer, at + whole.len() as u64, &last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{DepthPlane, SampleTile, Span, TileMask};
    use half::f16;

    /// `count` tiles, the `nth` with `nth + 1` samples.
    fn image(count: usize, with_doubtful: bool) -> SampleImage {
        let (mut tiles, mut depths) = (Vec::new(), Vec::new());
        for nth in 0..count {
            let mut rows = [0; TILE];
            rows[3] = u16::MAX >> (15 - nth % 16);
            tiles.push(SampleTile { tile_x: nth as u16, tile_y: 0, first: depths.len() as u32, rows });
            // Every other tile spans more than two octaves of depth, and takes a fourth byte.
            let far = if nth % 2 == 0 { 0.5 } else { 0.0 };
            depths.extend((0..=nth % 16).map(|sample| if sample == 0 { 0.6 } else { far }));
        }
        let tile_rows = std::array::from_fn(|row| u16::from(row == 3));
        SampleImage {
            camera: 0,
            span: Span { start: 0, end: 1 },
            color: vec![[f16::ONE; 3]; depths.len()],
            depth: DepthPlane::pack(&tiles, &depths),
            tiles,
            normal: None,
            doubtful: if with_doubtful { vec![TileMask { tile: 3, rows: tile_rows }] } else { Vec::new() },
            values: crate::capture::Values::default(),
        }
    }

    #[test]
    fn pieces_follow_each_other_without_gaps_and_are_no_longer_than_asked() {
        for with_doubtful in [false, true] {
            check_pieces(&image(40, with_doubtful));
        }
    }

    fn check_pieces(image: &SampleImage) {
        let whole = Piece::cut(image, u32::MAX);
        assert_eq!(whole.len(), 1);
        assert_eq!(whole[0].samples, 0..image.len());
        for max_words in [1, 60, 100, 333] {
            let pieces = Piece::cut(image, max_words);
            assert!(pieces.iter().all(|piece| piece.words() <= max_words || piece.tiles.len() == 1));
            let (mut tile, mut sample, mut byte) = (0, 0, 0);
            for piece in &pieces {
                let starts = (piece.tiles.start, piece.samples.start, piece.high.start);
                assert_eq!(starts, (tile, sample, byte));
                (tile, sample, byte) = (piece.tiles.end, piece.samples.end, piece.high.end);
            }
            assert_eq!((tile, sample, byte), (image.tiles.len(), image.len(), image.depth.high().len()));
        }
    }
}
