//! What a camera sees of the solids at rest: traced once, it spares `retrace` most of every frame.
//!
//! ```text
//! StillPicture ─┬─ surfels     every pixel's center
//!               └─ tiles       8×8 pixels each
//!                    ├─ points, taps   boxes around all that light is looked up for
//!                    ├─ edges          which pixels are filtered, and their color
//!                    └─ places         hits and light by part of the world: from when something first moves here
//! ```
//!
//! Nothing here waits: what two threads make at once is made twice and kept once. A thread that waited might be one of
//! the workers that the other needs.

use std::mem::size_of;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3};

use super::bvh::Bounds;
use super::shade::{self, Openness};
use super::trace::{self, CameraRays, SUBPIXELS, Surfel};
use super::world::{Nearest, Ray, World};
use crate::grid::Grid;

/// Columns and rows of a tile; its pixels fit the bits of a `u64`.
pub(super) const TILE: usize = 8;
/// By how much points rebuilt from 32-bit depths and normals may be off, m: these err by 10⁻⁶ at 10 m.
const MARGIN_M: f64 = 1e-4;

/// What one camera sees of the solids at rest.
pub(super) struct StillPicture {
    /// What stands at every pixel's center.
    pub(super) surfels: Grid<Surfel>,
    /// The picture in tiles; the last of a row or column may reach beyond it.
    pub(super) tiles: Grid<Tile>,
}

/// A square of pixels. Pixel `(x, y)` of the tile is bit `y · TILE + x`.
pub(super) struct Tile {
    /// Around the surface points whose light the tile shows, world space.
    pub(super) points: Bounds,
    /// Around the places where the surroundings of those points are felt, world space.
    pub(super) taps: Bounds,
    /// Whether rays meet two solids at once: which one is seen may depend on what moves elsewhere.
    pub(super) has_ties: bool,
    /// The pixels that are filtered.
    edges: u64,
    /// Their colors, in the order of bits.
    filtered: Box<[Vec3]>,
    places: OnceLock<Arc<Places>>,
}

/// Where the rays of a tile meet the solids at rest; `None` for the sky.
pub(super) struct Places {
    /// Through the centers of pixels, by bit.
    pub(super) centers: Box<[Option<Place>]>,
    /// Through the subpixels of the pixels that are filtered, in the order of bits.
    samples: Box<[[Option<Place>; SUBPIXELS.len()]]>,
}

/// A hit and what the solids at rest make of its color.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// The hit.
    pub(super) nearest: Nearest,
    /// Reflectance and glow.
    pub(super) color: (Vec3, f32),
    /// What the solids at rest leave open; `None` for a sample that shares the light of its pixel's center.
    pub(super) open: Option<Openness>,
}

/// Bytes that may still be kept, shared by all pictures of a recording.
pub(super) struct Allowance(AtomicUsize);

impl Allowance {
    /// Allows `bytes` in all.
    pub(super) fn new(bytes: usize) -> Self {
        Self(AtomicUsize::new(bytes))
    }

    /// Whether `bytes` more may be kept; they count from now on.
    pub(super) fn take(&self, bytes: usize) -> bool {
        let less = |left: usize| left.checked_sub(bytes);
        self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less).is_ok()
    }

    /// Gives back what was taken but not kept.
    fn give_back(&self, bytes: usize) {
        self.0.fetch_add(bytes, Ordering::Relaxed);
    }
}

impl StillPicture {
    /// Traces what the camera sees of `at_rest`, a world in which nothing moves.
    pub(super) fn new(at_rest: &World, view: &CameraRays, antialiased: bool) -> Self {
        let surfels = trace::surfels(at_rest, view);
        let (columns, rows) = (surfels.width().div_ceil(TILE), surfels.height().div_ceil(TILE));
        let tiles =
            trace::rows(columns, rows, |x, y| Tile::new(at_rest, view, &surfels, ((x, y), antialiased)));
        Self { surfels, tiles }
    }

    /// Bytes that a picture of so many pixels may take, places apart.
    pub(super) fn most_bytes(pixels: usize) -> usize {
        let per_tile = size_of::<Tile>() / (TILE * TILE) + 1;
        pixels.saturating_mul(size_of::<Surfel>() + size_of::<Vec3>() + per_tile)
    }
}

/// Bits and pixels of a tile that lie within a picture of the given size.
pub(super) fn pixels(
    tile: (usize, usize),
    (width, height): (usize, usize),
) -> impl Iterator<Item = (usize, (usize, usize))> {
    let (x0, y0) = (tile.0 * TILE, tile.1 * TILE);
    (y0..(y0 + TILE).min(height))
        .flat_map(move |y| (x0..(x0 + TILE).min(width)).map(move |x| ((y - y0) * TILE + x - x0, (x, y))))
}

impl Tile {
    fn new(
        at_rest: &World,
        view: &CameraRays,
        surfels: &Grid<Surfel>,
        (tile, antialiased): ((usize, usize), bool),
    ) -> Self {
        let (mut points, mut taps) = (Bounds::EMPTY, Bounds::EMPTY);
        let mut include = |point: DVec3, normal: DVec3| {
            let tap = shade::contact_center(&at_rest.light, point, normal);
            points = points.union(Bounds { low: point, high: point });
            taps = taps.union(Bounds { low: tap, high: tap });
        };
        let (mut edges, mut filtered, mut has_ties) = (0, Vec::new(), false);
        for (bit, (x, y)) in pixels(tile, surfels.size()) {
            let surfel = &surfels[(x, y)];
            has_ties |= surfel.is_tied;
            if surfel.inverse_depth > 0.0 {
                let (origin, direction) = view.center(x, y);
                let normal = DVec3::from(surfel.normal.map(f64::from));
                include(origin + direction / f64::from(surfel.inverse_depth), normal);
            }
            if antialiased && trace::is_edge(surfels, x, y) {
                edges |= 1 << bit;
                filtered.push(trace::filtered(at_rest, view, surfel, (x, y), |hit| {
                    has_ties |= hit.is_tied;
                    include(hit.point, hit.normal);
                }));
            }
        }
        Self {
            points: points.grown(MARGIN_M),
            taps: taps.grown(MARGIN_M),
            has_ties,
            edges,
            filtered: filtered.into(),
            places: OnceLock::new(),
        }
    }

    /// Which of the filtered pixels a bit stands for, in their order, where it is one.
    pub(super) fn edge(&self, bit: usize) -> Option<usize> {
        let before = self.edges & ((1 << bit) - 1);
        (self.edges >> bit & 1 == 1).then_some(before.count_ones() as usize)
    }

    /// Color of a filtered pixel as long as nothing moves.
    pub(super) fn filtered(&self, edge: usize) -> Vec3 {
        self.filtered[edge]
    }

    /// Where the tile's rays meet the solids at rest: kept from the last time, or traced and kept if allowed.
    pub(super) fn places(
        &self,
        at_rest: &World,
        view: &CameraRays,
        (tile, surfels): ((usize, usize), &Grid<Surfel>),
        allowance: &Allowance,
    ) -> Arc<Places> {
        if let Some(places) = self.places.get() {
            return places.clone();
        }
        let mut centers = vec![None; TILE * TILE];
        let mut samples = Vec::with_capacity(self.filtered.len());
        for (bit, pixel) in pixels(tile, surfels.size()) {
            centers[bit] = place(at_rest, view.center(pixel.0, pixel.1), None);
            if self.edge(bit).is_some() {
                let center = &surfels[pixel];
                samples.push(view.subpixels(pixel).map(|ray| place(at_rest, ray, Some(center))));
            }
        }
        let places = Arc::new(Places { centers: centers.into(), samples: samples.into() });
        let bytes = places.bytes();
        if allowance.take(bytes) && self.places.set(places.clone()).is_err() {
            allowance.give_back(bytes);
        }
        places
    }
}

impl Places {
    /// Through the subpixels of a filtered pixel.
    pub(super) fn samples(&self, edge: usize) -> &[Option<Place>; SUBPIXELS.len()] {
        &self.samples[edge]
    }

    fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.centers) + size_of_val(&*self.samples)
    }
}

/// Where a ray meets the solids at rest. The light of a sample that shares that of its pixel's `center` is left out.
fn place(at_rest: &World, ray: Ray, center: Option<&Surfel>) -> Option<Place> {
    let hit = at_rest.hit(ray)?;
    let shares = center.is_some_and(|center| trace::shares_light(center, &hit));
    Some(Place {
        nearest: Nearest { t: hit.t, solid: hit.solid, is_tied: hit.is_tied },
        color: at_rest.surface_color(&hit),
        open: (!shares).then(|| shade::openness(at_rest, &at_rest.still, &hit)),
    })
}
