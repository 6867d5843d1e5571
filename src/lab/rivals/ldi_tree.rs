//! An LDI tree: an octree with a layered depth image (LDI) in each cell.
//!
//! Source: C.-F. Chang, G. Bishop and A. Lastra, *LDI Tree: A Hierarchical Representation for Image-Based Rendering*, SIGGRAPH 1999.
//! Written from its abstract and introduction and from how others summarize it; its full text was not at hand. From there: each pixel
//! goes to the LDI whose sampling rate is nearest to its own, so that no rate is lost; the LDIs of all cells have one size and look at a
//! face of their cell; cells also hold what lies in the cells within them, filtered; rendering goes down to the cells whose LDI
//! pixels are as small as those of the output.
//!
//! What is ours: LDIs of 64×64 pixels, seen along the axis that is nearest to how its pixels were seen; a pixel is spread over the four
//! LDI pixels around it, and depths less than a pixel apart are one; squares of whole pixels, a half wider than the LDI pixel; a
//! z-buffer instead of blending by coverage, in which a coarser cell hides a finer one only where it is clearly nearer; the pixels of
//! one cell stay within it. What no cell knows shows the sky of the nearest camera that saw it in that direction. Gaps are left to
//! whoever compares, and not filled from coarser cells. Depths within a cell take 16 bits of a file, and filtered LDIs none.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3, UVec3};
use rayon::prelude::*;

use super::ldi_tree_cells::{DepthPixel, Key, Ldi, MAX_LEVEL, Root, SIDE};
use super::model::{RecordedView, RivalModel, deflated};
use super::sky::Sky;
use super::splat::Splatter;
use overlook_engine::capture::Camera;
use overlook_engine::color::{linear_from_srgb, srgb_from_linear};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::{NO_IMAGE, Picture};

/// How much wider than an LDI pixel its square is: pixels are spread over LDI pixels up to √2 closer than they are themselves.
const OVERLAP: f64 = 1.5;

/// By how much of its inverse depth a coarser cell's surface must be nearer to hide that of a finer one.
const CLEARLY_NEARER: f32 = 1.01;

/// A cell that holds something, itself or in cells within it.
struct Cell {
    /// The axis along which its LDIs are seen: 0, 1 or 2.
    axis: usize,
    /// Of the pixels that have this cell's sampling rate.
    own: Vec<DepthPixel>,
    /// Of these and of all cells within it; empty where there is none.
    filtered: Vec<DepthPixel>,
    children: Vec<Key>,
}

/// A pixel of a camera, and the cell it belongs to.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Placed {
    key: Key,
    view: u32,
    pixel: u32,
}

/// The tree, and the views for the sky.
pub(super) struct LdiTree {
    root: Root,
    cells: BTreeMap<Key, Cell>,
    views: Vec<RecordedView>,
}

impl LdiTree {
    /// # Errors
    /// `Invalid` where no camera saw a surface at a finite depth.
    pub(super) fn new(views: &[RecordedView]) -> Result<Self> {
        let root = root_of(views)
            .ok_or_else(|| Error::invalid("LDI tree", "no camera saw a surface at a finite depth"))?;
        let mut placed: Vec<Placed> = views
            .par_iter()
            .enumerate()
            .flat_map_iter(|(index, view)| {
                let pixels = 0..view.frame.inverse_depth.len();
                pixels.filter_map(move |pixel| {
                    let (point, depth) = point_of(view, pixel)?;
                    let k = view.camera.intrinsics;
                    let key = root.cell_of(point, depth / (k.fx * k.fy).sqrt());
                    Some(Placed { key, view: index as u32, pixel: pixel as u32 })
                })
            })
            .collect();
        placed.par_sort_unstable();
        let of_cells: Vec<&[Placed]> = placed.chunk_by(|a, b| a.key == b.key).collect();
        let cells = of_cells.par_iter().map(|placed| (placed[0].key, own_pixels(root, views, placed)));
        let mut tree = Self { root, cells: cells.collect(), views: views.to_vec() };
        (1..=MAX_LEVEL).rev().for_each(|level| tree.filter_into_parents_of(level));
        Ok(tree)
    }

    /// Makes the filtered LDIs of all cells that have some of a level within them.
    fn filter_into_parents_of(&mut self, level: u32) {
        let mut children: BTreeMap<Key, Vec<Key>> = BTreeMap::new();
        let of_level = Key::new(level, UVec3::ZERO)..Key::new(level + 1, UVec3::ZERO);
        for (key, _) in self.cells.range(of_level) {
            if let Some(parent) = key.parent() {
                children.entry(parent).or_default().push(*key);
            }
        }
        let children: Vec<(Key, Vec<Key>)> = children.into_iter().collect();
        let filtered = children.into_par_iter().map(|(parent, children)| {
            let known = self.cells.get(&parent);
            let axis = known.map_or_else(|| self.cells[&children[0]].axis, |cell| cell.axis);
            let mut ldi = Ldi::new(self.root, parent, axis);
            let own = known.map(|cell| cell.own.clone()).unwrap_or_default();
            for pixel in &own {
                ldi.pixels[usize::from(pixel.pixel)].push(*pixel);
            }
            for key in &children {
                let cell = &self.cells[key];
                for pixel in cell.shown(true) {
                    // A quarter of the area; what several cameras saw covers no more than what one did.
                    ldi.add(self.point(*key, cell.axis, pixel), pixel.color, 0.25 * pixel.weight.min(1.0));
                }
            }
            (parent, Cell { axis, own, filtered: ldi.finish(), children })
        });
        let filtered: Vec<(Key, Cell)> = filtered.collect();
        self.cells.extend(filtered);
    }

    /// Where a depth pixel of a cell is.
    fn point(&self, key: Key, axis: usize, pixel: &DepthPixel) -> DVec3 {
        let mut local = DVec3::ZERO;
        local[axis] = f64::from(pixel.depth);
        local[(axis + 1) % 3] = (usize::from(pixel.pixel) % SIDE) as f64 + 0.5;
        local[(axis + 2) % 3] = (usize::from(pixel.pixel) / SIDE) as f64 + 0.5;
        self.root.corner(key) + self.root.spacing(key.level()) * local
    }

    /// The cells to be shown to a camera, and whether with all that is within them; by level, the finest last.
    fn shown_to(&self, target: &Camera) -> Vec<Vec<(Key, bool)>> {
        let mut shown = vec![Vec::new(); MAX_LEVEL as usize + 1];
        let mut open: Vec<Key> = self.cells.keys().next().into_iter().copied().collect();
        let k = target.intrinsics;
        while let Some(key) = open.pop() {
            let Some(nearest) = self.nearest_depth(key, target) else { continue };
            let pixels = self.root.spacing(key.level()) * (k.fx * k.fy).sqrt() / nearest;
            let is_fine_enough = nearest > 0.0 && pixels <= 1.0;
            shown[key.level() as usize].push((key, is_fine_enough));
            if !is_fine_enough {
                open.extend(&self.cells[&key].children);
            }
        }
        shown
    }

    /// Depth of a cell's nearest corner; `None` where all of it is behind the camera or beside its picture.
    fn nearest_depth(&self, key: Key, target: &Camera) -> Option<f64> {
        let (corner, width) = (self.root.corner(key), self.root.cell_width(key.level()));
        let to_camera = target.camera_from_world();
        let corners: [DVec3; 8] = std::array::from_fn(|nth| {
            let part = |bit: usize| (nth >> bit & 1) as f64;
            to_camera.transform_point3(corner + width * DVec3::new(part(0), part(1), part(2)))
        });
        let k = target.intrinsics;
        let (columns, rows) = (f64::from(k.width), f64::from(k.height));
        // Each is negative on the far side of one side of the picture; a square may reach in from a few pixels outside.
        let sides: [&dyn Fn(&DVec3) -> f64; 5] = [
            &|p| p.z,
            &|p| k.fx * p.x + (k.cx + 8.0) * p.z,
            &|p| (columns - k.cx + 8.0) * p.z - k.fx * p.x,
            &|p| k.fy * p.y + (k.cy + 8.0) * p.z,
            &|p| (rows - k.cy + 8.0) * p.z - k.fy * p.y,
        ];
        if sides.iter().any(|side| corners.iter().all(|corner| side(corner) <= 0.0)) {
            return None;
        }
        Some(corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min))
    }
}

impl Cell {
    /// The depth pixels of the cell alone, or with all that is within it.
    fn shown(&self, is_whole: bool) -> &[DepthPixel] {
        if is_whole && !self.children.is_empty() { &self.filtered } else { &self.own }
    }
}

/// The place in the world of a camera's pixel, and its depth; `None` where there is no finite one.
fn point_of(view: &RecordedView, pixel: usize) -> Option<(DVec3, f64)> {
    let inverse_depth = f64::from(view.frame.inverse_depth.as_slice()[pixel]);
    if inverse_depth <= 0.0 {
        return None;
    }
    let width = view.frame.size().0;
    let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
    Some((view.camera.unproject(center, 1.0 / inverse_depth), 1.0 / inverse_depth))
}

/// The smallest cube around all surfaces; `None` where there is none.
fn root_of(views: &[RecordedView]) -> Option<Root> {
    let bounds = views.par_iter().filter_map(|view| {
        let points = (0..view.frame.inverse_depth.len()).filter_map(|pixel| Some(point_of(view, pixel)?.0));
        points.fold(None, |bounds: Option<(DVec3, DVec3)>, point| {
            let (low, high) = bounds.unwrap_or((point, point));
            Some((low.min(point), high.max(point)))
        })
    });
    let (low, high) = bounds.reduce_with(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    let width = (high - low).max_element().max(f64::MIN_POSITIVE);
    Some(Root { low, width })
}

/// The LDI of the pixels of one cell.
fn own_pixels(root: Root, views: &[RecordedView], placed: &[Placed]) -> Cell {
    let mut seen_along = DVec3::ZERO;
    let points = || {
        placed.iter().filter_map(|placed| {
            let (view, pixel) = (&views[placed.view as usize], placed.pixel as usize);
            Some((view, pixel, point_of(view, pixel)?.0))
        })
    };
    for (view, _, point) in points() {
        seen_along += (point - view.camera.position_in_world()).normalize_or_zero().abs();
    }
    let axis = (0..3).max_by(|a, b| seen_along[*a].total_cmp(&seen_along[*b])).unwrap_or(2);
    let mut ldi = Ldi::new(root, placed[0].key, axis);
    for (view, pixel, point) in points() {
        let color = view.frame.color.as_slice()[pixel].map(|linear| srgb_from_linear(linear.to_f32()));
        ldi.add(point, color, 1.0);
    }
    Cell { axis, own: ldi.finish(), filtered: Vec::new(), children: Vec::new() }
}

impl RivalModel for LdiTree {
    fn render(&self, target: &Camera) -> Picture {
        let (width, height) = target.intrinsics.size();
        let mut picture = Picture::empty(width, height);
        for (level, cells) in self.shown_to(target).into_iter().enumerate().rev() {
            if cells.is_empty() {
                continue;
            }
            let mut splatter = Splatter::new(target);
            let wide = OVERLAP * self.root.spacing(level as u32);
            for (key, is_whole) in cells {
                let cell = &self.cells[&key];
                for pixel in cell.shown(is_whole) {
                    let color = pixel.color.map(linear_from_srgb);
                    splatter.add_point(self.point(key, cell.axis, pixel), wide, color);
                }
            }
            behind(&mut picture, &splatter.finish());
        }
        let sky = Sky::seen_from(&self.views, target);
        for y in 0..height {
            for x in 0..width {
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let ray = target.world_from_camera.matrix3 * target.intrinsics.ray_in_camera(center);
                if picture.image[(x, y)] == NO_IMAGE
                    && let Some(color) = sky.color(ray)
                {
                    (picture.color[(x, y)], picture.inverse_depth[(x, y)]) = (color, 0.0);
                    picture.image[(x, y)] = 0;
                }
            }
        }
        picture
    }

    fn bytes(&self) -> Option<u64> {
        let mut planes = vec![Vec::new(); 7];
        for (key, cell) in self.cells.iter().filter(|(_, cell)| !cell.own.is_empty()) {
            planes[0].extend(key.0.to_be_bytes());
            planes[0].push(cell.axis as u8);
            let mut counts = [0_u8; SIDE * SIDE];
            for pixel in &cell.own {
                let count = &mut counts[usize::from(pixel.pixel)];
                *count = count.saturating_add(1);
                let depth = (pixel.depth * 1023.0).clamp(0.0, f32::from(u16::MAX)) as u16;
                let [high, low] = depth.to_be_bytes();
                let [r, g, b] = pixel.color.map(|encoded| (255.0 * encoded + 0.5).clamp(0.0, 255.0) as u8);
                planes[2..].iter_mut().zip([high, low, r, g, b]).for_each(|(plane, byte)| plane.push(byte));
            }
            planes[1].extend(counts);
        }
        Some(deflated(&planes.concat()))
    }
}

/// Puts the picture of coarser cells behind that of finer ones: it shows where they have nothing, or something clearly behind it.
fn behind(finer: &mut Picture, coarser: &Picture) {
    let depths = finer.inverse_depth.as_mut_slice().iter_mut().zip(coarser.inverse_depth.as_slice());
    for (index, (known, new)) in depths.enumerate() {
        if *new > 0.0 && *new > *known * CLEARLY_NEARER {
            *known = *new;
            finer.color.as_mut_slice()[index] = coarser.color.as_slice()[index];
            finer.image.as_mut_slice()[index] = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::slope;
    use super::*;

    /// Root mean square error of gray, and the share of pixels with a wrong depth, where the tree shows something.
    fn apart(tree: &LdiTree, truth: &RecordedView) -> (f64, f64, usize) {
        let picture = tree.render(&truth.camera);
        let (mut squares, mut wrong, mut count) = (0.0, 0.0, 0);
        for index in 0..picture.image.len() {
            if picture.image.as_slice()[index] == NO_IMAGE {
                continue;
            }
            count += 1;
            let known = truth.frame.color.as_slice()[index][0].to_f32();
            squares += f64::from(picture.color.as_slice()[index][0] - known).powi(2);
            let ratio = picture.inverse_depth.as_slice()[index] / truth.frame.inverse_depth.as_slice()[index];
            wrong += f64::from(u8::from((ratio - 1.0).abs() > 0.05));
        }
        ((squares / f64::from(count)).sqrt(), wrong / f64::from(count), count as usize)
    }

    /// The same picture by a lens of a longer focal length: of a narrower surface.
    fn zoomed(times: f64) -> RecordedView {
        let mut view = slope(0.0);
        view.camera.intrinsics.fx *= times;
        view.camera.intrinsics.fy *= times;
        view
    }

    #[test]
    fn a_slope_seen_by_two_cameras_is_shown_between_them_where_it_is_and_as_it_is() {
        let tree = LdiTree::new(&[slope(-0.3), slope(0.3)]).unwrap();
        let (error, wrong, count) = apart(&tree, &slope(0.1));
        assert!(error < 0.02 && wrong == 0.0, "{error} {wrong}");
        assert!(count > 48 * 32 * 9 / 10, "{count}");
        assert!(LdiTree::new(&[]).is_err());
    }

    #[test]
    fn a_second_look_at_the_same_rate_adds_nothing_and_one_at_twice_the_rate_another_level() {
        let levels = |views: &[RecordedView]| {
            let tree = LdiTree::new(views).unwrap();
            let own = tree.cells.iter().filter(|(_, cell)| !cell.own.is_empty());
            let levels: std::collections::BTreeSet<u32> = own.map(|(key, _)| key.level()).collect();
            (levels, tree.cells.values().map(|cell| cell.own.len()).sum::<usize>())
        };
        let (once, pixels) = levels(&[slope(0.0)]);
        assert_eq!(levels(&[slope(0.0), slope(0.0)]), (once.clone(), pixels));
        let (both, more) = levels(&[slope(0.0), zoomed(2.0)]);
        assert_eq!(both.last().unwrap() - once.last().unwrap(), 1, "{both:?} {once:?}");
        assert!(more > pixels * 3 / 2, "no rate is lost: {more} {pixels}");
    }

    #[test]
    fn from_far_away_the_root_alone_is_shown_with_all_that_is_in_it() {
        let tree = LdiTree::new(&[slope(-0.3), zoomed(8.0)]).unwrap();
        let mut far = slope(0.0);
        far.camera.world_from_camera.translation.z -= 1000.0;
        let shown: Vec<_> = tree.shown_to(&far.camera).into_iter().flatten().collect();
        assert_eq!(shown, [(Key::new(0, UVec3::ZERO), true)]);
        let near: Vec<_> = tree.shown_to(&zoomed(8.0).camera).into_iter().flatten().collect();
        assert!(near.len() > 2 && near.iter().any(|(key, _)| key.level() > 0));
        let mut away = slope(0.0);
        away.camera.world_from_camera.matrix3.z_axis *= -1.0;
        assert!(tree.shown_to(&away.camera).into_iter().flatten().next().is_none());
    }
}
