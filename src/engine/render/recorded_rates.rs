//! How finely the cameras recorded what a picture shows.
//!
//! Rates are recorded pixels along a pixel of the picture: above 1 the picture is the coarser one, below 1 it magnifies.

use rayon::prelude::*;

use super::geometry::Projector;
use super::vantage::Vantage;
use crate::samples::{DepthTile, SampleImage, SampleSet, SampleTile, TILE};

/// Rates over a picture.
#[derive(Clone, Debug, Default)]
pub(super) struct RecordedRates {
    /// Rates, largest first, and the pixels of the picture that each holds for: of all that it shows, and of what is not at infinity.
    descending: [Vec<(f32, f32)>; 2],
}

/// A tile of samples in the picture.
struct SeenTile {
    rate: f32,
    /// Pixels of the picture that its samples cover.
    area: f32,
    is_finite: bool,
}

impl RecordedRates {
    /// At a vantage.
    pub(super) fn of(samples: &SampleSet, vantage: &Vantage) -> Self {
        let images = || samples.images_at(vantage.frame);
        // Longer spans count if there are any, so that the resolution does not change from frame to frame.
        let has_longer = images().any(|image| image.span.len() > 1 && !image.is_empty());
        let chosen: Vec<_> = images().filter(|image| !has_longer || image.span.len() > 1).collect();
        let seen: Vec<SeenTile> =
            chosen.par_iter().flat_map_iter(|image| seen_tiles(image, samples, vantage)).collect();
        let sorted = |tiles: &mut dyn Iterator<Item = &SeenTile>| {
            let mut rates: Vec<(f32, f32)> = tiles.map(|tile| (tile.rate, tile.area)).collect();
            rates.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
            rates
        };
        let surfaces = sorted(&mut seen.iter().filter(|tile| tile.is_finite));
        Self { descending: [sorted(&mut seen.iter()), surfaces] }
    }

    /// The rate that a share of the picture, 0 to 1, reaches or exceeds, or of the surfaces in it, if that is more: things before a
    /// wide sky are not lost. 0 if it shows nothing.
    pub(super) fn of_share(&self, share: f64) -> f32 {
        self.descending.iter().map(|rates| rate_of_share(rates, share)).fold(0.0, f32::max)
    }
}

/// The rate that a share of the pixels reaches or exceeds; 0 if there are none.
fn rate_of_share(descending: &[(f32, f32)], share: f64) -> f32 {
    let all: f64 = descending.iter().map(|(_, area)| f64::from(*area)).sum();
    let mut covered = 0.0;
    let found = descending.iter().find(|(_, area)| {
        covered += f64::from(*area);
        covered >= share * all
    });
    found.map_or(0.0, |(rate, _)| *rate)
}

/// The tiles whose centers are visible.
fn seen_tiles<'a>(
    image: &'a SampleImage,
    samples: &SampleSet,
    vantage: &Vantage,
) -> impl Iterator<Item = SeenTile> + 'a {
    let target = &vantage.camera;
    let projector = samples.cameras.get(image.camera as usize).map(|camera| Projector::new(camera, target));
    let (width, height) = target.intrinsics.size();
    let seen = move |(tile, depth): (&SampleTile, &DepthTile)| {
        let projector = projector?;
        let middle = |tile: u16| f32::from(tile) * TILE as f32 + 0.5 * TILE as f32;
        let inverse_depth = 0.5 * (f32::from_bits(depth.farthest) + f32::from_bits(depth.nearest));
        let point = projector.point_of_any(middle(tile.tile_x), middle(tile.tile_y), inverse_depth);
        let [u, v] = projector.position(point, inverse_depth);
        let is_seen = point.z > 0.0 && (0.0..width as f32).contains(&u) && (0.0..height as f32).contains(&v);
        let rate = if projector.source_is_orthographic {
            projector.magnification(inverse_depth, point.z.recip()).recip()
        } else {
            point.z / projector.focal_ratio
        };
        let area = tile.count() as f32 / (rate * rate);
        is_seen.then_some(SeenTile { rate, area, is_finite: depth.nearest != 0 })
    };
    image.tiles.iter().zip(image.depth.tiles()).filter_map(seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::render::tests::scene;

    #[test]
    fn a_picture_of_half_the_size_has_twice_the_rate_everywhere() {
        let (samples, vantage) = scene(DemoSpec::new("orrery").cameras(3).size((96, 64)), 0);
        let mut halved = vantage.clone();
        let lens = &mut halved.camera.intrinsics;
        (lens.width, lens.height) = (lens.width / 2, lens.height / 2);
        for length in [&mut lens.fx, &mut lens.fy, &mut lens.cx, &mut lens.cy] {
            *length *= 0.5;
        }
        let (once, twice) = (RecordedRates::of(&samples, &halved), RecordedRates::of(&samples, &vantage));
        for share in [0.1, 0.5, 0.9] {
            let ratio = once.of_share(share) / twice.of_share(share);
            assert!((ratio - 2.0).abs() < 1e-3, "{share}: {ratio}");
        }
        assert!(once.of_share(0.1) >= once.of_share(0.9));
        assert_eq!(RecordedRates::default().of_share(0.5), 0.0);
    }
}
