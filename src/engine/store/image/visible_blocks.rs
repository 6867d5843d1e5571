//! Which blocks of a store a vantage needs.
//!
//! ```text
//! block + bounds of its depths ─▶ box ─ meets the vantage's frustum? ─▶ may be seen ─┬──────────────────────────▶ needed
//!                                        its projection into every camera: blocks there that the renderer compares with ─┘
//! ```
//!
//! A pixel `(x, y)` of a camera at inverse depth `w` is the point `direction(x, y) + w · position` in homogeneous coordinates, so
//! that a box of pixels and inverse depths, 0 for infinity included, is the hull of its eight corners, and is outside a plane where
//! all of these are. What is painted is also looked up in all cameras, whose nearer samples hide it: blocks where a box that may
//! be seen is projected to are needed at whatever depth. Both tests grow boxes by what the renderers' footprints reach. Where a camera is
//! orthographic all blocks are needed.

use glam::{DMat3, DVec3};

use super::image_chunk::BlockEntry;
use crate::capture::Camera;
use crate::store::codec::BLOCK;

/// Pixels by which the footprints of samples reach beyond their block: twice what renderers stretch them to, and a pixel for rounding.
const SOURCE_REACH: f64 = 4.0;

/// Pixels by which the picture is enlarged on all sides.
const PICTURE_REACH: f64 = 4.0;

/// More blocks than any picture has along one side.
const MAX_BLOCKS: f64 = 65_536.0;

/// Blocks of a camera's pictures, by place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct VisibleBlocks {
    across: usize,
    is_visible: Vec<bool>,
}

impl VisibleBlocks {
    /// No block of a grid with these columns and rows.
    fn none((across, down): (usize, usize)) -> Self {
        Self { across, is_visible: vec![false; across * down] }
    }

    /// Whether the block in a column and row is one of them.
    pub(crate) fn has(&self, (x, y): (u16, u16)) -> bool {
        self.is_visible.get(usize::from(y) * self.across + usize::from(x)).copied().unwrap_or(false)
    }

    /// Adds the blocks that pixels `[left, right] × [top, bottom]` touch.
    fn add(&mut self, [left, top]: [f64; 2], [right, bottom]: [f64; 2]) {
        let down = self.is_visible.len() / self.across.max(1);
        // What is too large comes after the last block, however large it is.
        let block = |pixel: f64| (pixel / BLOCK as f64).clamp(0.0, MAX_BLOCKS) as usize;
        if right < 0.0 || bottom < 0.0 {
            return;
        }
        for y in block(top)..(block(bottom) + 1).min(down) {
            let row = y * self.across;
            let columns = block(left).min(self.across)..(block(right) + 1).min(self.across);
            self.is_visible[row + columns.start.min(columns.end)..row + columns.end].fill(true);
        }
    }

    fn add_all(&mut self) {
        self.is_visible.fill(true);
    }
}

/// Eight points in homogeneous coordinates whose hull holds what a block may hold: `direction + w · position`.
struct Hull([(DVec3, f64); 8]);

impl Hull {
    fn of(block: &BlockEntry, camera: &Camera) -> Self {
        let corner = |index: u16| f64::from(index) * BLOCK as f64;
        let low = [corner(block.place.0), corner(block.place.1)].map(|corner| corner - SOURCE_REACH);
        let high = low.map(|corner| corner + BLOCK as f64 + 2.0 * SOURCE_REACH);
        let (far, near) = (f64::from(block.inverse_depth.0), f64::from(block.inverse_depth.1));
        let side =
            |bits: usize, bit: usize, low: f64, high: f64| if bits >> bit & 1 == 1 { high } else { low };
        Self(std::array::from_fn(|bits| {
            let pixel = glam::DVec2::new(side(bits, 0, low[0], high[0]), side(bits, 1, low[1], high[1]));
            let direction = camera.world_from_camera.matrix3 * camera.intrinsics.ray_in_camera(pixel);
            (direction, side(bits, 2, far, near))
        }))
    }

    /// The corners in another camera's space, as far as their distance goes.
    fn seen_by(&self, position: DVec3, eye: &Eye) -> [DVec3; 8] {
        let offset = position - eye.position;
        self.0.map(|(direction, w)| eye.camera_from_world * (direction + offset * w))
    }
}

/// A camera prepared for projecting many points.
struct Eye {
    camera_from_world: DMat3,
    position: DVec3,
    focal: [f64; 2],
    center: [f64; 2],
    size: [f64; 2],
}

impl Eye {
    fn of(camera: &Camera) -> Self {
        let k = camera.intrinsics;
        Self {
            camera_from_world: camera.world_from_camera.matrix3.inverse(),
            position: camera.position_in_world(),
            focal: [k.fx, k.fy],
            center: [k.cx, k.cy],
            size: [f64::from(k.width), f64::from(k.height)],
        }
    }

    /// Whether the hull of some points may be in the picture.
    fn may_see(&self, points: &[DVec3; 8]) -> bool {
        let planes = |point: &DVec3| {
            let across = |axis: usize| self.focal[axis] * point[axis];
            let low = |axis: usize| across(axis) + (self.center[axis] + PICTURE_REACH) * point.z;
            let high =
                |axis: usize| (self.size[axis] + PICTURE_REACH - self.center[axis]) * point.z - across(axis);
            [point.z, low(0), high(0), low(1), high(1)]
        };
        let distances = points.map(|point| planes(&point));
        // Written so that what is not a number is seen.
        (0..5).all(|plane| !distances.iter().all(|distance| distance[plane] < 0.0))
    }

    /// Adds the blocks that the hull of some points is projected to.
    fn add_projection(&self, points: &[DVec3; 8], visible: &mut VisibleBlocks) {
        if points.iter().all(|point| point.z <= 0.0) {
            return;
        }
        if !points.iter().all(|point| point.z > 0.0) {
            return visible.add_all();
        }
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for axis in 0..2 {
                let pixel = self.center[axis] + self.focal[axis] * point[axis] / point.z;
                if pixel.is_nan() {
                    return visible.add_all();
                }
                low[axis] = low[axis].min(pixel);
                high[axis] = high[axis].max(pixel);
            }
        }
        visible.add(low.map(|pixel| pixel - PICTURE_REACH), high.map(|pixel| pixel + PICTURE_REACH));
    }
}

/// For each camera the blocks that a vantage needs, given the blocks that there are, with their cameras.
pub(crate) fn visible_blocks<'a>(
    vantage: &Camera,
    cameras: &[Camera],
    blocks: impl Iterator<Item = (usize, &'a BlockEntry)> + Clone,
) -> Vec<VisibleBlocks> {
    // Grids are as large as the existing blocks demand: a file may claim any size of its pictures.
    let mut extents = vec![(0, 0); cameras.len()];
    for (camera, block) in blocks.clone() {
        let (across, down): &mut (usize, usize) = &mut extents[camera];
        *across = (*across).max(usize::from(block.place.0) + 1);
        *down = (*down).max(usize::from(block.place.1) + 1);
    }
    let mut visible: Vec<VisibleBlocks> = extents.into_iter().map(VisibleBlocks::none).collect();
    // What parallel lines of sight see is no such hull.
    if cameras.iter().chain([vantage]).any(|camera| camera.intrinsics.is_orthographic()) {
        visible.iter_mut().for_each(VisibleBlocks::add_all);
        return visible;
    }
    let vantage = Eye::of(vantage);
    let eyes: Vec<Eye> = cameras.iter().map(Eye::of).collect();
    for (camera, block) in blocks {
        let hull = Hull::of(block, &cameras[camera]);
        let position = eyes[camera].position;
        if !vantage.may_see(&hull.seen_by(position, &vantage)) {
            continue;
        }
        for (eye, visible) in eyes.iter().zip(&mut visible) {
            eye.add_projection(&hull.seen_by(position, eye), visible);
        }
        let corner = [block.place.0, block.place.1].map(|index| f64::from(index) * BLOCK as f64);
        visible[camera].add(corner, corner);
    }
    visible
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;

    #[test]
    fn what_reaches_beyond_all_numbers_touches_every_block_up_to_the_edge() {
        let mut visible = VisibleBlocks::none((3, 2));
        visible.add([100.0, -5.0], [f64::INFINITY, 1e300]);
        assert_eq!(visible.is_visible, [false, true, true, false, true, true]);
        let mut visible = VisibleBlocks::none((3, 2));
        visible.add([f64::INFINITY, 0.0], [f64::INFINITY, 10.0]);
        assert_eq!(visible.is_visible, [false; 6]);
        let camera = Camera::look_at(
            "c",
            Intrinsics::from_horizontal_angle(192, 128, 0.9),
            DVec3::NEG_Y,
            DVec3::ZERO,
            DVec3::Z,
        );
        for nearly_beside in [f64::MIN_POSITIVE, 1e-300] {
            let mut visible = VisibleBlocks::none((3, 2));
            let points = std::array::from_fn(|i| DVec3::new(i as f64 - 3.5, 3.5 - i as f64, nearly_beside));
            Eye::of(&camera).add_projection(&points, &mut visible);
            assert_eq!(visible.is_visible, [true; 6], "{nearly_beside:e}");
        }
    }
}
