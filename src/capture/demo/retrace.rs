//! The picture of a moment from what the camera sees of the solids at rest, bit for bit the one that `trace` makes.
//!
//! A picture depends on the two parts of the world by minima alone: of ray parameters, of clearances from the sun's
//! cone, of distances to the surroundings. What the part at rest has to say is in a [`StillPicture`]. A frame finds the
//! tiles that a moving solid may cover, shade or dim, by boxes; asks the moving solids about the rays and points of
//! these tiles; and takes the minimum. A pixel keeps its color unless a minimum changed: its own, or, where color is
//! filtered over the pixel, one of its samples' or neighbors'.
//!
//! The one thing that no minimum decides is which of two solids is seen where their faces lie in one plane: such rays ask
//! the whole world again.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};

use super::shade;
use super::still::{Allowance, Place, Places, StillPicture, TILE, pixels};
use super::trace::{self, CameraRays, Picture, Surfel};
use super::world::{Hit, Nearest, Ray, World};
use crate::capture::{Camera, Frame};
use crate::grid::Grid;

/// Solids that come nearer to the camera's plane than this, m, may be anywhere in the picture.
const NEAR_M: f64 = 1e-3;
/// By how much projected corners may be off, pixels.
const MARGIN_PX: f64 = 1e-3;

/// A moment to be retraced.
pub(super) struct Moment<'a> {
    /// What the camera sees of `at_rest`.
    pub(super) still: &'a StillPicture,
    /// The world without what moves.
    pub(super) at_rest: &'a World,
    /// The world at this moment.
    pub(super) world: &'a World,
    /// The camera's rays.
    pub(super) view: CameraRays<'a>,
    /// What may be kept for further moments.
    pub(super) allowance: &'a Allowance,
}

/// What moving solids may do to a tile.
#[derive(Clone, Copy, Default)]
struct Reach {
    /// They may cover part of it.
    covers: bool,
    /// They may take light from it.
    dims: bool,
    /// They may decide which of two solids at one place is seen.
    settles: bool,
}

/// A tile that moving solids reach.
struct Retraced {
    reach: Reach,
    places: Arc<Places>,
    /// The pixels that are no longer as in the still picture, by bit.
    changed: Vec<(usize, Surfel)>,
}

/// The picture of the moment.
pub(super) fn picture(moment: &Moment, wanted: Picture) -> Frame {
    let tiles = &moment.still.tiles;
    let covered = covered_tiles(moment.world, moment.view.camera, tiles.size());
    let retraced = trace::rows(tiles.width(), tiles.height(), |x, y| moment.retrace((x, y), covered[(x, y)]));
    let mut surfels = moment.still.surfels.clone();
    let mut is_changed = Grid::filled(surfels.width(), surfels.height(), false);
    for (index, tile) in retraced.as_slice().iter().enumerate() {
        let corner = (index % tiles.width() * TILE, index / tiles.width() * TILE);
        for (bit, surfel) in tile.iter().flat_map(|tile| &tile.changed) {
            let pixel = (corner.0 + bit % TILE, corner.1 + bit / TILE);
            surfels[pixel] = *surfel;
            is_changed[pixel] = true;
        }
    }
    trace::frame(&surfels, wanted, |x, y| {
        if !wanted.antialiased {
            return surfels[(x, y)].color;
        }
        let edge = moment.still.tiles[(x / TILE, y / TILE)].edge(y % TILE * TILE + x % TILE);
        let is_edge =
            if any_around(&is_changed, x, y) { trace::is_edge(&surfels, x, y) } else { edge.is_some() };
        if !is_edge {
            return surfels[(x, y)].color;
        }
        match edge {
            Some(edge) => moment.filtered(retraced[(x / TILE, y / TILE)].as_ref(), edge, &surfels, (x, y)),
            None => trace::filtered(moment.world, &moment.view, &surfels[(x, y)], (x, y), |_| ()),
        }
    })
}

/// Whether the value is true at a pixel or one of its eight neighbors.
fn any_around(values: &Grid<bool>, x: usize, y: usize) -> bool {
    let (x_end, y_end) = ((x + 2).min(values.width()), (y + 2).min(values.height()));
    (y.saturating_sub(1)..y_end).any(|row| values.row(row)[x.saturating_sub(1)..x_end].contains(&true))
}

/// The tiles that a moving solid may be seen in, out of so many columns and rows.
fn covered_tiles(world: &World, camera: &Camera, (columns, rows): (usize, usize)) -> Grid<bool> {
    let mut covered = Grid::filled(columns, rows, false);
    for index in world.moving.members() {
        let Some((low, high)) = screen_box(camera, world.solids[index].outer_box()) else {
            return Grid::filled(columns, rows, true);
        };
        let tile = |at: DVec2| (at / TILE as f64).floor();
        let (low, high) = (tile(low - MARGIN_PX).max(DVec2::ZERO), tile(high + MARGIN_PX));
        if high.min_element() < 0.0 {
            continue;
        }
        for y in low.y as usize..(high.y as usize + 1).min(rows) {
            for x in low.x as usize..(high.x as usize + 1).min(columns) {
                covered[(x, y)] = true;
            }
        }
    }
    covered
}

/// The rectangle of the image, pixels, that a box with the given center and half axes lies within; `None` where it is
/// not all in front of the camera.
fn screen_box(camera: &Camera, (center, half_axes): (DVec3, [DVec3; 3])) -> Option<(DVec2, DVec2)> {
    let camera_from_world = camera.camera_from_world();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for corner in 0..8 {
        let side = |axis: usize| if corner >> axis & 1 == 1 { half_axes[axis] } else { -half_axes[axis] };
        let point = camera_from_world.transform_point3(center + side(0) + side(1) + side(2));
        let at = camera.intrinsics.project(point).filter(|_| point.z > NEAR_M)?;
        (low, high) = (low.min(at), high.max(at));
    }
    Some((low, high))
}

impl Moment<'_> {
    /// What moving solids change at the centers of a tile's pixels; `None` where they do not reach it.
    fn retrace(&self, tile: (usize, usize), covers: bool) -> Option<Retraced> {
        let still = &self.still.tiles[tile];
        let contact_m = self.world.light.contact;
        let dims = self.world.moving.may_dim(&still.points, &still.taps, contact_m);
        let reach = Reach { covers, dims, settles: still.has_ties };
        if !reach.covers && !reach.dims && !reach.settles {
            return None;
        }
        let surfels = &self.still.surfels;
        let places = still.places(self.at_rest, &self.view, (tile, surfels), self.allowance);
        let changed = pixels(tile, surfels.size()).filter_map(|(bit, pixel)| {
            let place = places.centers[bit].as_ref();
            Some((bit, self.surfel(reach, place, pixel)?))
        });
        Some(Retraced { reach, changed: changed.collect(), places: places.clone() })
    }

    /// What stands at a pixel's center where that is not what the still picture has there.
    fn surfel(&self, reach: Reach, place: Option<&Place>, (x, y): (usize, usize)) -> Option<Surfel> {
        let ray = self.view.center(x, y);
        if let Some(hit) = self.covering(reach, place, ray) {
            return Some(trace::surfel(self.world, ray, Some(hit)));
        }
        let place = place.filter(|_| reach.dims)?;
        let hit = self.world.hit_at(ray, place.nearest);
        let at_rest = place.open?;
        let open = at_rest.min(shade::openness(self.world, &self.world.moving, &hit));
        if open == at_rest {
            return None;
        }
        let irradiance = shade::irradiance_through(&self.world.light, &hit, &open);
        let color = shade::sent(place.color, irradiance);
        Some(Surfel { color, irradiance, ..self.still.surfels[(x, y)] })
    }

    /// What is seen instead of what the ray meets at rest.
    fn covering(&self, reach: Reach, place: Option<&Place>, ray: Ray) -> Option<Hit> {
        if !reach.covers && !reach.settles {
            return None;
        }
        let before = place.map_or(Nearest::NONE, |place| place.nearest);
        let nearest = self.world.nearest(&self.world.moving, ray, before);
        if before.is_tied || nearest.is_tied {
            return self.world.hit(ray).filter(|hit| hit.solid != before.solid);
        }
        (nearest != before).then(|| self.world.hit_at(ray, nearest))
    }

    /// The color of a pixel that the still picture filters too, as edge number `edge` of its tile.
    fn filtered(
        &self,
        retraced: Option<&Retraced>,
        edge: usize,
        surfels: &Grid<Surfel>,
        (x, y): (usize, usize),
    ) -> Vec3 {
        let Some(Retraced { reach, places, .. }) = retraced else {
            return self.still.tiles[(x / TILE, y / TILE)].filtered(edge);
        };
        let center = &surfels[(x, y)];
        let (rays, samples) = (self.view.subpixels((x, y)), places.samples(edge));
        trace::mean(
            center,
            std::array::from_fn(|index| self.sample(*reach, center, rays[index], samples[index].as_ref())),
        )
    }

    /// The color of a sample of a pixel; `place` is where its ray meets the solids at rest.
    fn sample(&self, reach: Reach, center: &Surfel, ray: Ray, place: Option<&Place>) -> Vec3 {
        if let Some(hit) = self.covering(reach, place, ray) {
            return trace::sample(self.world, center, &hit);
        }
        let Some(place) = place else { return shade::sky(ray.1) };
        if place.open.is_none() && place.nearest.solid as u32 == center.solid {
            return shade::sent(place.color, center.irradiance);
        }
        let hit = self.world.hit_at(ray, place.nearest);
        let irradiance = match place.open {
            Some(open) if reach.dims => {
                let moving = shade::openness(self.world, &self.world.moving, &hit);
                shade::irradiance_through(&self.world.light, &hit, &open.min(moving))
            }
            Some(open) => shade::irradiance_through(&self.world.light, &hit, &open),
            // Something that moves covers the center whose light it shared.
            None => shade::irradiance(self.world, &hit),
        };
        shade::sent(place.color, irradiance)
    }
}
