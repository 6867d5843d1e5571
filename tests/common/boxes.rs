//! An analytic scene of boxes with sides along the axes, before a sky at infinity: walls, bars, windows and shafts.
//!
//! Cameras look along +z with y down.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use half::f16;
use overlook_engine::capture::{
    Camera, Capture, CaptureParts, Frame, FrameSource, INVALID_INVERSE_DEPTH, Intrinsics, Values,
};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;

/// A box of one color.
#[derive(Clone)]
pub(crate) struct Block {
    /// The corner with the smallest and the one with the largest coordinates, at frame 0.
    pub(crate) corners: [DVec3; 2],
    pub(crate) color: [f32; 3],
    /// How far it moves from one frame to the next.
    pub(crate) step: DVec3,
}

/// Color of the sky in a direction of length 1.
pub(crate) type SkyColor = fn(DVec3) -> [f32; 3];

#[derive(Clone)]
pub(crate) struct Blocks {
    pub(crate) blocks: Vec<Block>,
    pub(crate) sky: SkyColor,
}

/// A resting box that spans these ranges.
pub(crate) fn block(x: [f64; 2], y: [f64; 2], z: [f64; 2], color: [f32; 3]) -> Block {
    let corner = |end: usize| DVec3::new(x[end], y[end], z[end]);
    Block { corners: [corner(0), corner(1)], color, step: DVec3::ZERO }
}

/// A camera at `(x, y, 0)` whose focal length is its width.
pub(crate) fn eye(x: f64, y: f64, size: u32) -> Camera {
    let intrinsics = Intrinsics::centered(size, size, f64::from(size));
    Camera {
        name: format!("eye at {x}, {y}"),
        intrinsics,
        world_from_camera: DAffine3::from_mat3_translation(DMat3::IDENTITY, DVec3::new(x, y, 0.0)),
    }
}

impl Blocks {
    /// Distance factor of `ray` to the nearest box, and its color.
    fn hit(&self, frame: usize, eye: DVec3, ray: DVec3) -> Option<(f64, [f32; 3])> {
        let entry = |block: &Block| {
            let moved = block.step * frame as f64;
            let ends = block.corners.map(|corner| (corner + moved - eye) / ray);
            let (enter, leave) = (ends[0].min(ends[1]).max_element(), ends[0].max(ends[1]).min_element());
            (enter > 0.0 && enter < leave).then_some((enter, block.color))
        };
        self.blocks.iter().filter_map(entry).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// What `camera` records.
    pub(crate) fn trace(&self, camera: &Camera, frame: usize) -> Frame {
        let (width, height) = camera.intrinsics.size();
        let mut color = Grid::filled(width, height, [f16::ZERO; 3]);
        let mut inverse_depth = Grid::filled(width, height, INVALID_INVERSE_DEPTH);
        for y in 0..height {
            for x in 0..width {
                let ray = camera.intrinsics.ray_in_camera(DVec2::new(x as f64, y as f64) + 0.5);
                let hit = self.hit(frame, camera.position_in_world(), ray);
                let (w, shown) =
                    hit.map_or((0.0, (self.sky)(ray.normalize_or_zero())), |(t, c)| (1.0 / t, c));
                color[(x, y)] = shown.map(f16::from_f32);
                inverse_depth[(x, y)] = w as f32;
            }
        }
        Frame {
            color,
            inverse_depth,
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        }
    }

    /// The scene recorded by `cameras` over `frames` frames.
    pub(crate) fn record(&self, cameras: &[Camera], frames: usize) -> Capture {
        Capture::new(
            CaptureParts {
                name: "boxes".to_owned(),
                frame_numbers: (0..frames as i64).collect(),
                up_in_world: DVec3::NEG_Y,
                has_normals: false,
                antialiased_color: false,
                warnings: Vec::new(),
                source: Arc::new(BlocksRecorder { scene: self.clone(), cameras: cameras.to_vec() }),
                cameras: cameras.to_vec(),
            },
            256 << 20,
        )
    }
}

struct BlocksRecorder {
    scene: Blocks,
    cameras: Vec<Camera>,
}

impl FrameSource for BlocksRecorder {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        Ok(self.scene.trace(&self.cameras[camera], frame))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("boxes, camera {camera}, frame {frame}")
    }
}
