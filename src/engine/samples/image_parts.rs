//! Parts of a sample image, and parts put together.

use half::f16;

use super::depth_plane::DepthPlane;
use super::oct_normal::OctNormal;
use super::sample_set::{SampleImage, Span};
use super::tile::{Sample, SampleTile, TILE, TileMask};

/// An image that is put together sample by sample, in the order in which it stores them.
struct GrowingImage {
    image: SampleImage,
    inverse_depths: Vec<f32>,
}

/// What an image holds at one pixel.
#[derive(Clone, Copy)]
struct PixelSample<'a> {
    x: usize,
    y: usize,
    color: [f16; 3],
    inverse_depth: f32,
    normal: Option<OctNormal>,
    is_doubtful: bool,
    values: &'a [f32],
}

impl<'a> PixelSample<'a> {
    fn of(image: &'a SampleImage, sample: &Sample, inverse_depths: &[f32]) -> Self {
        Self {
            x: sample.x,
            y: sample.y,
            color: image.color[sample.index],
            inverse_depth: inverse_depths[sample.index],
            normal: image.normal.as_ref().map(|normals| normals[sample.index]),
            is_doubtful: !image.doubtful.is_empty() && image.is_doubtful(sample.x, sample.y),
            values: image.values.of(sample.index),
        }
    }

    /// Where it is in the order of storage: tiles row by row, then rows within the tile.
    fn place(&self) -> [usize; 4] {
        [self.y / TILE, self.x / TILE, self.y, self.x]
    }
}

impl GrowingImage {
    fn new(like: &SampleImage, span: Span) -> Self {
        Self { image: SampleImage { span, ..like.without_samples() }, inverse_depths: Vec::new() }
    }

    fn push(&mut self, sample: PixelSample<'_>) {
        let part = &mut self.image;
        let (tile_x, tile_y) = ((sample.x / TILE) as u16, (sample.y / TILE) as u16);
        if part.tiles.last().is_none_or(|tile| (tile.tile_x, tile.tile_y) != (tile_x, tile_y)) {
            let first = self.inverse_depths.len() as u32;
            part.tiles.push(SampleTile { tile_x, tile_y, first, rows: [0; TILE] });
        }
        let bit = 1 << (sample.x % TILE);
        if let Some(tile) = part.tiles.last_mut() {
            tile.rows[sample.y % TILE] |= bit;
        }
        if sample.is_doubtful {
            let tile = part.tiles.len() as u32 - 1;
            if part.doubtful.last().is_none_or(|mask| mask.tile != tile) {
                part.doubtful.push(TileMask { tile, rows: [0; TILE] });
            }
            if let Some(mask) = part.doubtful.last_mut() {
                mask.rows[sample.y % TILE] |= bit;
            }
        }
        part.color.push(sample.color);
        part.values.push(sample.values);
        if let (Some(normals), Some(normal)) = (&mut part.normal, sample.normal) {
            normals.push(normal);
        }
        self.inverse_depths.push(sample.inverse_depth);
    }

    fn finish(mut self) -> SampleImage {
        self.image.depth = DepthPlane::pack(&self.image.tiles, &self.inverse_depths);
        self.image
    }
}

impl SampleImage {
    /// The samples that `keep` accepts, given each and its inverse depth, as an image of `span`.
    #[must_use]
    pub fn part(&self, span: Span, keep: impl Fn(&Sample, f32) -> bool) -> Self {
        let inverse_depths = self.inverse_depths();
        let mut part = GrowingImage::new(self, span);
        for sample in self.samples().filter(|sample| keep(sample, inverse_depths[sample.index])) {
            part.push(PixelSample::of(self, &sample, &inverse_depths));
        }
        part.finish()
    }

    /// Joins images of this one's camera to one image of this one's span; no two hold the same pixel.
    #[must_use]
    pub fn joined_with(&self, others: &[Self]) -> Self {
        let mut samples = Vec::new();
        for image in std::iter::once(self).chain(others) {
            let inverse_depths = image.inverse_depths();
            samples.extend(image.samples().map(|sample| PixelSample::of(image, &sample, &inverse_depths)));
        }
        samples.sort_unstable_by_key(PixelSample::place);
        let mut joined = GrowingImage::new(self, self.span);
        for sample in samples {
            joined.push(sample);
        }
        joined.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_keeps_its_place_depth_color_and_doubt() {
        let mut rows = [0; TILE];
        (rows[2], rows[9]) = (0b101, 0b1000);
        let tiles = vec![
            SampleTile { tile_x: 1, tile_y: 0, first: 0, rows },
            SampleTile { tile_x: 2, tile_y: 3, first: 3, rows },
        ];
        let depths = [0.5, 0.0, 0.25, 2.0, 3.0, 4.0];
        let image = SampleImage {
            camera: 4,
            span: Span { start: 0, end: 1 },
            depth: DepthPlane::pack(&tiles, &depths),
            color: (0..6).map(|nth| [f16::from_f32(nth as f32); 3]).collect(),
            normal: None,
            doubtful: vec![TileMask { tile: 1, rows }],
            tiles,
            values: crate::capture::Values::default(),
        };
        assert_eq!(image.part(image.span, |_, _| true), image);
        let some = image.part(image.span, |sample, depth| (sample.x, sample.y) == (35, 57) || depth == 0.0);
        let places: Vec<_> = some.samples().map(|sample| (sample.x, sample.y)).collect();
        assert_eq!((places, some.inverse_depths()), (vec![(18, 2), (35, 57)], vec![0.0, 4.0]));
        assert_eq!(some.color.iter().map(|color| color[0].to_f32()).collect::<Vec<_>>(), [1.0, 5.0]);
        assert!(some.is_doubtful(35, 57) && !some.is_doubtful(18, 2));
        assert!(image.part(image.span, |_, depth| depth > 1.0).tiles.len() == 1);
    }
}
