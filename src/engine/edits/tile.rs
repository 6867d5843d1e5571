//! Tiles of samples, asked of regions as a whole, so that a selection costs what is near it and not what a store holds.
//!
//! Source: none; it is interval arithmetic over the sets that a region combines. Whatever a tile as a whole does not decide, its samples do.

use glam::{DAffine3, DVec2, DVec3};

use super::region_test::RegionTest;
use super::seen::{Evidence, ImageMarks, PixelRays, Seen};
use crate::capture::{Camera, PixelBox};
use crate::samples::{Sample, SampleImage, SampleTile, TILE, TileDepths};

/// By what share of their size numbers have to differ to be told apart whatever was rounded.
const ROUNDED: f64 = 1e-9;

/// Pixels by which positions in pictures have to.
const ROUNDED_PIXELS: f64 = 1e-3;

/// A tile of an image.
pub(super) struct Tile<'a> {
    image: &'a SampleImage,
    index: usize,
    held: &'a SampleTile,
    depths: TileDepths<'a>,
    /// Between the edges of its outermost pixels.
    pixels: [DVec2; 2],
    pub(super) space: PixelBox,
}

impl<'a> Tile<'a> {
    /// All of an image that is of this camera.
    pub(super) fn all(image: &'a SampleImage, camera: &Camera) -> impl Iterator<Item = Self> {
        image.tiles.iter().enumerate().map(move |(index, tile)| {
            let depths = image.depth.tile(index, tile.first, tile.count());
            let low = DVec2::new(f64::from(tile.tile_x), f64::from(tile.tile_y)) * TILE as f64;
            let pixels = [low, low + TILE as f64];
            let space = PixelBox::new(camera, pixels, depths.bounds());
            Self { image, index, held: tile, depths, pixels, space }
        })
    }

    /// Its samples with their inverse depths.
    pub(super) fn samples(&self) -> impl Iterator<Item = (Sample, f32)> + use<'a> {
        let (first, depths) = (self.held.first as usize, self.depths);
        self.held.samples().map(move |sample| (sample, depths.get(sample.index - first)))
    }

    /// What marks say of all of its samples; `None` where they differ.
    fn all_alike(&self, marks: &[bool]) -> Option<bool> {
        let first = self.held.first as usize;
        let own = &marks[first..first + self.held.count()];
        let is_marked = own.first().copied()?;
        own.iter().all(|mark| *mark == is_marked).then_some(is_marked)
    }

    fn is_outside(&self, [low, high]: [DVec2; 2]) -> bool {
        self.pixels[1].cmplt(low).any() || self.pixels[0].cmpgt(high).any()
    }
}

/// Whether `a` is larger than `b`, whatever was rounded.
fn exceeds(a: f64, b: f64) -> bool {
    a - b > ROUNDED * (a.abs() + b.abs())
}

/// Whether some side of a box around the origin has all of a hull beyond it.
fn is_beside(corners: &[(DVec3, f64); 8], half_size: DVec3) -> bool {
    let is_beyond = |axis: usize, side: f64| {
        corners.iter().all(|(point, w)| exceeds(side * point[axis], half_size[axis] * w))
    };
    (0..3).any(|axis| is_beyond(axis, 1.0) || is_beyond(axis, -1.0))
}

impl RegionTest {
    /// What holds for all samples of a tile; `None` where they have to be asked. `marks` are those of its image.
    pub(super) fn of_tile(&self, tile: &Tile<'_>, marks: &[ImageMarks]) -> Option<bool> {
        let no_sample = |is_none: bool| is_none.then_some(false);
        match self {
            Self::Constant(value) => Some(*value),
            Self::Box { box_from_world, half_size } => {
                no_sample(is_beside(&tile.space.corners_in(box_from_world), *half_size))
            }
            Self::Sphere { center, radius_squared } => {
                let corners = tile.space.corners_in(&DAffine3::from_translation(-*center));
                no_sample(is_beside(&corners, DVec3::splat(radius_squared.sqrt())))
            }
            Self::HalfSpace { point, normal } => {
                let corners = tile.space.corners_in(&DAffine3::from_translation(-*point));
                let is_all = |side: f64| {
                    corners
                        .iter()
                        .all(|(at, _)| side * at.dot(*normal) > ROUNDED * at.length() * normal.length())
                };
                is_all(1.0).then_some(true).or(no_sample(is_all(-1.0)))
            }
            Self::Depth { from, to } => {
                let (far, near) = tile.depths.bounds();
                let [nearest, farthest] = [near, far].map(|inverse_depth| 1.0 / f64::from(inverse_depth));
                let is_within = (*from..=*to).contains(&nearest) && (*from..=*to).contains(&farthest);
                is_within.then_some(true).or(no_sample(farthest < *from || nearest > *to))
            }
            Self::Pixels(area) => no_sample(tile.is_outside(area.bounds())),
            Self::View { camera_from_world, lens, area, .. } => {
                let place = tile.space.in_picture(lens, camera_from_world);
                no_sample(place.is_off(area.bounds(), ROUNDED_PIXELS))
            }
            Self::Marked(at) => match marks.get(*at).and_then(Option::as_ref) {
                Some(marks) => tile.all_alike(marks),
                None => Some(false),
            },
            Self::Doubtful => no_sample(tile.image.doubtful_rows(tile.index).is_none()),
            Self::Contradicted
            | Self::ConfirmedByFewerThan(_)
            | Self::SeenByOneCamera
            | Self::Angle { .. }
            | Self::Value { .. }
            | Self::Color { .. } => None,
            Self::Any(parts) => combined(parts, tile, marks, true),
            Self::All(parts) => combined(parts, tile, marks, false),
            Self::Not(part) => part.of_tile(tile, marks).map(|inside| !inside),
        }
    }

    /// Calls `found` with every sample of an image that it holds.
    pub(super) fn for_each_inside(
        &self,
        image: &SampleImage,
        camera: &Camera,
        evidence: &Evidence<'_>,
        mut found: impl FnMut(&Sample),
    ) {
        let rays = PixelRays::of(camera);
        for tile in Tile::all(image, camera) {
            let known = self.of_tile(&tile, evidence.marks());
            if known == Some(false) {
                continue;
            }
            for (sample, inverse_depth) in tile.samples() {
                let is_inside = known.unwrap_or_else(|| {
                    let mut seen: Seen<'_> = rays.seen(sample.x, sample.y, inverse_depth);
                    evidence.add_to(&mut seen, &sample);
                    self.contains(&seen)
                });
                if is_inside {
                    found(&sample);
                }
            }
        }
    }
}

/// *Any* or *all* of some parts: one part that is as `decisive` decides, and so do all that are not.
fn combined(parts: &[RegionTest], tile: &Tile<'_>, marks: &[ImageMarks], decisive: bool) -> Option<bool> {
    let mut all = Some(!decisive);
    for part in parts {
        match part.of_tile(tile, marks) {
            Some(inside) if inside == decisive => return Some(decisive),
            Some(_) => {}
            None => all = None,
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use half::f16;
    use proptest::prelude::*;

    use super::*;
    use crate::capture::{Intrinsics, Values};
    use crate::edits::region::{Region, Stroke, Viewpoint};
    use crate::edits::region_test::RegionContext;
    use crate::samples::{DepthPlane, Span};

    fn camera(name: &str, eye: DVec3) -> Camera {
        Camera::look_at(name, Intrinsics::from_horizontal_angle(64, 48, 0.9), eye, DVec3::Y * 4.0, DVec3::Z)
    }

    /// A surface that steps and slopes, before the sky.
    fn image() -> SampleImage {
        let tile = |place: u16| SampleTile {
            tile_x: place % 4,
            tile_y: place / 4,
            first: u32::from(place) * 256,
            rows: [u16::MAX; TILE],
        };
        let tiles: Vec<SampleTile> = (0..12).map(tile).collect();
        let depth_at = |sample: Sample| match (sample.x, sample.y) {
            (x, y) if x + y > 90 => 0.0,
            (x, y) if x > 28 => 1.0 / (2.0 + 0.02 * x as f32 + 0.01 * y as f32),
            (x, y) => 1.0 / (5.0 - 0.03 * (x + y) as f32),
        };
        let color_at =
            |sample: Sample| [sample.x as f32 / 64.0, sample.y as f32 / 48.0, 0.25].map(f16::from_f32);
        let depths: Vec<f32> = tiles.iter().flat_map(SampleTile::samples).map(depth_at).collect();
        SampleImage {
            camera: 0,
            span: Span { start: 0, end: 1 },
            depth: DepthPlane::pack(&tiles, &depths),
            color: tiles.iter().flat_map(SampleTile::samples).map(color_at).collect(),
            normal: None,
            doubtful: Vec::new(),
            values: Values::missing(0, depths.len()),
            tiles,
        }
    }

    fn any_region() -> impl Strategy<Value = Region> {
        let place = || prop::array::uniform3(-2.0..6.0_f64);
        let size = || 0.1..3.0_f64;
        let drawn = (0.0..40.0_f64, 0.0..30.0_f64, 1.0..30.0_f64).prop_map(|(x, y, side)| {
            (vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]], Vec::<Stroke>::new())
        });
        let half_space = |(point, normal)| Region::HalfSpace { point, normal };
        let leaf = prop_oneof![
            (place(), prop::array::uniform3(size()), prop::array::uniform3(-180.0..180.0_f64)).prop_map(
                |(center, half_size, rotation_degrees)| Region::Box { center, half_size, rotation_degrees }
            ),
            (place(), size()).prop_map(|(center, radius)| Region::Sphere { center, radius }),
            (place(), prop::array::uniform3(-1.0..1.0_f64)).prop_map(half_space),
            (0.5..4.0_f64, size()).prop_map(|(from, span)| Region::Depth { from, to: from + span }),
            (prop::array::uniform3(0.0..1.0_f64), 0.0..200.0_f64)
                .prop_map(|(linear, tolerance)| Region::Color { linear, tolerance }),
            drawn.clone().prop_map(|(outline, strokes)| Region::Pixels {
                camera: "own".into(),
                frame: None,
                outline,
                strokes
            }),
            (place(), drawn).prop_map(|(eye, (outline, strokes))| Region::View {
                viewpoint: Viewpoint::of(&camera("v", DVec3::from(eye))),
                frame: None,
                outline,
                strokes,
                depth: None
            }),
        ];
        leaf.prop_recursive(2, 8, 3, |part| {
            let parts = || prop::collection::vec(part.clone(), 1..4);
            prop_oneof![
                parts().prop_map(Region::Any),
                parts().prop_map(Region::All),
                parts().prop_map(Region::Without),
                part.clone().prop_map(|part| Region::Not(Box::new(part))),
            ]
        })
    }

    proptest! {
        #[test]
        fn what_a_tile_decides_is_what_each_of_its_samples_would(region in any_region()) {
            let (own, image) = (camera("own", DVec3::new(0.3, -0.2, 0.5)), image());
            let test = RegionTest::new(&region, RegionContext { camera: &own, channels: &[], marked: &[] });
            let evidence = Evidence::new(&image, &[], &[], false, &own).unwrap();
            let mut found = Vec::new();
            test.for_each_inside(&image, &own, &evidence, |sample| found.push(sample.index));
            let (rays, depths) = (PixelRays::of(&own), image.inverse_depths());
            let asked = image.samples().filter(|sample| {
                let mut seen: Seen<'_> = rays.seen(sample.x, sample.y, depths[sample.index]);
                evidence.add_to(&mut seen, sample);
                test.contains(&seen)
            });
            prop_assert_eq!(found, asked.map(|sample| sample.index).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_region_asks_only_tiles_that_it_may_cut() {
        let (own, image) = (camera("own", DVec3::ZERO), image());
        let undecided = |region: &Region| {
            let test = RegionTest::new(region, RegionContext { camera: &own, channels: &[], marked: &[] });
            Tile::all(&image, &own).filter(|tile| test.of_tile(tile, &[]).is_none()).count()
        };
        let square = vec![[2.0, 2.0], [14.0, 2.0], [14.0, 14.0], [2.0, 14.0]];
        let in_picture = Region::Pixels {
            camera: "own".into(),
            frame: None,
            outline: square.clone(),
            strokes: Vec::new(),
        };
        let in_view = Region::View {
            viewpoint: Viewpoint::of(&own),
            frame: None,
            outline: square,
            strokes: Vec::new(),
            depth: None,
        };
        let far_away = Region::Sphere { center: [50.0, 0.0, 0.0], radius: 1.0 };
        assert_eq!([&in_picture, &in_view, &far_away].map(undecided), [1, 1, 0]);
    }
}
