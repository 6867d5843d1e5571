//! Which blocks of a store a vantage needs.
//!
//! ```text
//! block + bounds of its depths ─▶ box ─ meets the vantage's frustum? ─▶ may be seen ─┬──────────────────────────▶ needed
//!                                        its projection into every camera: blocks there that the renderer compares with ─┘
//! ```
//!
//! What a block may hold is in the hull of a [`PixelBox`], and is outside a plane where all of its corners are. What is painted is also
//! looked up in all cameras, whose nearer samples hide it: blocks where a box that may be seen is projected to are needed at whatever
//! depth. Both tests grow boxes by what the renderers' footprints reach. Where a camera is orthographic all blocks are needed.

use glam::{DAffine3, DVec2, DVec3};

use super::image_chunk::BlockEntry;
use crate::capture::{BoxInPicture, Camera, PixelBox, any_orthographic};
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

    /// The block that holds a pixel of a picture of so many columns and rows.
    pub(crate) fn of_pixel((width, height): (usize, usize), (x, y): (usize, usize)) -> Self {
        let mut blocks = Self::none((width.div_ceil(BLOCK), height.div_ceil(BLOCK)));
        let place = (y / BLOCK) * blocks.across + x / BLOCK;
        if let Some(is_visible) = blocks.is_visible.get_mut(place).filter(|_| x < width) {
            *is_visible = true;
        }
        blocks
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

    /// Adds the blocks that a box of another camera is projected to.
    fn add_place(&mut self, place: BoxInPicture) {
        match place {
            BoxInPicture::Nowhere => {}
            BoxInPicture::Between([low, high]) => {
                self.add((low - PICTURE_REACH).to_array(), (high + PICTURE_REACH).to_array());
            }
            BoxInPicture::Anywhere => self.add_all(),
        }
    }

    fn add_all(&mut self) {
        self.is_visible.fill(true);
    }
}

/// What a block may hold.
fn box_of(block: &BlockEntry, camera: &Camera) -> PixelBox {
    let low = DVec2::new(f64::from(block.place.0), f64::from(block.place.1)) * BLOCK as f64 - SOURCE_REACH;
    PixelBox::new(camera, [low, low + BLOCK as f64 + 2.0 * SOURCE_REACH], block.inverse_depth)
}

/// The vantage, prepared for many boxes.
struct Eye {
    camera_from_world: DAffine3,
    focal: [f64; 2],
    center: [f64; 2],
    size: [f64; 2],
}

impl Eye {
    fn of(camera: &Camera) -> Self {
        let k = camera.intrinsics;
        Self {
            camera_from_world: camera.camera_from_world(),
            focal: [k.fx, k.fy],
            center: [k.cx, k.cy],
            size: [f64::from(k.width), f64::from(k.height)],
        }
    }

    /// Whether a box may be in the picture.
    fn may_see(&self, held: &PixelBox) -> bool {
        let planes = |point: &DVec3| {
            let across = |axis: usize| self.focal[axis] * point[axis];
            let low = |axis: usize| across(axis) + (self.center[axis] + PICTURE_REACH) * point.z;
            let high =
                |axis: usize| (self.size[axis] + PICTURE_REACH - self.center[axis]) * point.z - across(axis);
            [point.z, low(0), high(0), low(1), high(1)]
        };
        let distances = held.corners_in(&self.camera_from_world).map(|(point, _)| planes(&point));
        // Written so that what is not a number is seen.
        (0..5).all(|plane| !distances.iter().all(|distance| distance[plane] < 0.0))
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
    if any_orthographic(cameras.iter().chain([vantage])) {
        visible.iter_mut().for_each(VisibleBlocks::add_all);
        return visible;
    }
    let vantage = Eye::of(vantage);
    let poses: Vec<DAffine3> = cameras.iter().map(Camera::camera_from_world).collect();
    for (camera, block) in blocks {
        let held = box_of(block, &cameras[camera]);
        if !vantage.may_see(&held) {
            continue;
        }
        for ((other, camera_from_world), visible) in cameras.iter().zip(&poses).zip(&mut visible) {
            visible.add_place(held.in_picture(&other.intrinsics, camera_from_world));
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
            let points =
                std::array::from_fn(|i| (DVec3::new(i as f64 - 3.5, 3.5 - i as f64, nearly_beside), 1.0));
            visible.add_place(BoxInPicture::of(&points, &camera.intrinsics));
            assert_eq!(visible.is_visible, [true; 6], "{nearly_beside:e}");
        }
    }
}
