//! Some of the samples of an image.

use half::f16;

use super::depth_plane::{DepthPlane, TILE_SAMPLES};
use super::sample_set::SampleImage;
use super::tile::{SampleTile, TILE, TileMask};

impl SampleImage {
    /// The samples for which `keep` is true, which gets column, row and inverse depth. Tiles that keep none are left out.
    #[must_use]
    pub(crate) fn retained(&self, keep: impl Fn(usize, usize, f32) -> bool) -> Self {
        let mut some = Self {
            tiles: Vec::with_capacity(self.tiles.len()),
            color: Vec::with_capacity(self.color.len()),
            depth: DepthPlane::with_capacity(self.tiles.len(), self.color.len()),
            normal: self.normal.as_ref().map(|normals| Vec::with_capacity(normals.len())),
            doubtful: Vec::new(),
            ..self.without_samples()
        };
        let mut all = [0.0; TILE_SAMPLES];
        let mut depths = Vec::with_capacity(TILE_SAMPLES);
        for (index, tile) in self.tiles.iter().enumerate() {
            self.depth.tile(index, tile.first, tile.count()).unpack(&mut all);
            let corner = [tile.tile_x, tile.tile_y].map(|place| usize::from(place) * TILE);
            let mut kept = SampleTile { first: some.color.len() as u32, rows: [0; TILE], ..*tile };
            let (mut color, mut nth): (Vec<[f16; 3]>, usize) = (Vec::new(), 0);
            depths.clear();
            for (row, columns) in tile.rows.iter().enumerate() {
                for column in (0..TILE).filter(|column| columns >> column & 1 == 1) {
                    if keep(corner[0] + column, corner[1] + row, all[nth]) {
                        kept.rows[row] |= 1 << column;
                        depths.push(all[nth]);
                        let at = tile.first as usize + nth;
                        color.push(self.color[at]);
                        if let (Some(to), Some(from)) = (&mut some.normal, &self.normal) {
                            to.push(from[at]);
                        }
                    }
                    nth += 1;
                }
            }
            if depths.is_empty() {
                continue;
            }
            if let Some(rows) = self.doubtful_rows(index) {
                let rows = std::array::from_fn(|row| rows[row] & kept.rows[row]);
                if rows != [0; TILE] {
                    some.doubtful.push(TileMask { tile: some.tiles.len() as u32, rows });
                }
            }
            some.depth.push_tile(&depths);
            some.color.append(&mut color);
            some.tiles.push(kept);
        }
        some
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Span;

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
        };
        assert_eq!(image.retained(|_, _, _| true), image);
        let some = image.retained(|x, y, depth| (x, y) == (35, 57) || depth == 0.0);
        let places: Vec<_> = some.samples().map(|sample| (sample.x, sample.y)).collect();
        assert_eq!((places, some.inverse_depths()), (vec![(18, 2), (35, 57)], vec![0.0, 4.0]));
        assert_eq!(some.color.iter().map(|color| color[0].to_f32()).collect::<Vec<_>>(), [1.0, 5.0]);
        assert!(some.is_doubtful(35, 57) && !some.is_doubtful(18, 2));
        assert!(image.retained(|_, _, depth| depth > 1.0).tiles.len() == 1);
    }
}
