//! Which solids may be between a point and the sun.
//!
//! Seen along the sun's rays every solid covers a rectangle of the plane across them. A grid over that plane lists the
//! solids of each cell, penumbra included, so that a shadow looks only at solids that can cast it.

use glam::{DVec2, DVec3};

/// Cells along each side of the grid.
const CELLS: usize = 64;

/// A solid as the sun sees it.
#[derive(Clone, Copy, Debug)]
struct Outline {
    /// Across the sun's rays, m.
    low: DVec2,
    high: DVec2,
    /// Along the rays toward the sun, m: nearest to and farthest from the ground.
    below: f64,
    above: f64,
}

/// The grid.
#[derive(Debug)]
pub(crate) struct ShadowMap {
    across: [DVec3; 2],
    to_sun: DVec3,
    spread: f64,
    outlines: Vec<Outline>,
    low: DVec2,
    cells_per_m: DVec2,
    /// Where each cell's list starts in `items`; one more than there are cells.
    starts: Vec<u32>,
    items: Vec<u32>,
    /// Height along the sun's rays that no lit point is below, m.
    deepest: f64,
}

impl ShadowMap {
    /// A map over solids that are given by their centers and half axes (half extent times direction), world space, for
    /// a sun whose penumbra is `spread` m wide per meter behind an edge. No lit point may lie deeper along the sun's
    /// rays than these solids.
    pub(crate) fn new(to_sun: DVec3, spread: f64, solids: impl Iterator<Item = (DVec3, [DVec3; 3])>) -> Self {
        let across = {
            let u = to_sun.any_orthonormal_vector();
            [u, to_sun.cross(u)]
        };
        let outlines: Vec<Outline> =
            solids.map(|(center, half_axes)| outline(across, to_sun, center, half_axes)).collect();
        let low = outlines.iter().fold(DVec2::INFINITY, |low, o| low.min(o.low));
        let high = outlines.iter().fold(DVec2::NEG_INFINITY, |high, o| high.max(o.high));
        let deepest = outlines.iter().fold(f64::INFINITY, |deepest, o| deepest.min(o.below));
        let cells_per_m = DVec2::splat(CELLS as f64) / (high - low).max(DVec2::splat(1e-6));
        let (starts, items) = (Vec::new(), Vec::new());
        let mut map = Self { across, to_sun, spread, outlines, low, cells_per_m, starts, items, deepest };
        map.fill();
        map
    }

    /// Lists the solids of each cell: first counts them, then puts each in its place.
    fn fill(&mut self) {
        let spans: Vec<_> = self
            .outlines
            .iter()
            .map(|outline| {
                let margin = DVec2::splat(self.spread * (outline.above - self.deepest));
                (self.cell(outline.low - margin), self.cell(outline.high + margin))
            })
            .collect();
        let cells_of = |((x0, y0), (x1, y1)): ((usize, usize), (usize, usize))| {
            (y0..=y1).flat_map(move |y| y * CELLS + x0..=y * CELLS + x1)
        };
        let mut starts = vec![0_u32; CELLS * CELLS + 1];
        for cell in spans.iter().copied().flat_map(cells_of) {
            starts[cell + 1] += 1;
        }
        for cell in 0..CELLS * CELLS {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        self.items = vec![0; starts[CELLS * CELLS] as usize];
        for (index, span) in spans.into_iter().enumerate() {
            for cell in cells_of(span) {
                self.items[next[cell] as usize] = index as u32;
                next[cell] += 1;
            }
        }
        self.starts = starts;
    }

    fn cell(&self, place: DVec2) -> (usize, usize) {
        let cell =
            ((place - self.low) * self.cells_per_m).clamp(DVec2::ZERO, DVec2::splat((CELLS - 1) as f64));
        (cell.x as usize, cell.y as usize)
    }

    /// Calls `found(solid, from, to)` for solids that the cone of light to `point` may touch, between the given
    /// distances from it; stops once `found` gives `false`.
    pub(crate) fn for_each_toward_sun(&self, point: DVec3, mut found: impl FnMut(usize, f64, f64) -> bool) {
        let place = DVec2::new(self.across[0].dot(point), self.across[1].dot(point));
        let height = self.to_sun.dot(point);
        let (x, y) = self.cell(place);
        let cell = y * CELLS + x;
        for item in &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
            let outline = &self.outlines[*item as usize];
            let to = outline.above - height;
            let beside = (outline.low - place).max(place - outline.high).max_element();
            if to > 0.0 && beside < self.spread * to && !found(*item as usize, outline.below - height, to) {
                return;
            }
        }
    }
}

fn outline(across: [DVec3; 2], to_sun: DVec3, center: DVec3, half_axes: [DVec3; 3]) -> Outline {
    let reach = |direction: DVec3| half_axes.iter().map(|axis| axis.dot(direction).abs()).sum::<f64>();
    let middle = DVec2::new(across[0].dot(center), across[1].dot(center));
    let half = DVec2::new(reach(across[0]), reach(across[1]));
    let (height, depth) = (to_sun.dot(center), reach(to_sun));
    Outline { low: middle - half, high: middle + half, below: height - depth, above: height + depth }
}
