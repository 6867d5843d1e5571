//! What the CPU writes and shaders read, field for field as in `shaders/common/*.wgsl`. A test compares sizes and offsets.

use bytemuck::{Pod, Zeroable};

use crate::capture::Camera;
use crate::render::geometry::Projector;
use crate::render::input::focal;

/// `Stage` in `stage.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuStage {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Index of the kernel in `Kernel::ALL`.
    pub(super) kernel: u32,
    pub(super) step: u32,
    pub(super) first_tile: u32,
    pub(super) tile_count: u32,
    pub(super) piece_count: u32,
    pub(super) surface_ratio: f32,
    pub(super) first_ray: [f32; 3],
    pub(super) background_tiles: u32,
    pub(super) ray_across: [f32; 3],
    pub(super) entries_at: u32,
    pub(super) ray_down: [f32; 3],
    pub(super) all_tiles: u32,
    pub(super) pruned: u32,
    pub(super) subpixels: u32,
    pub(super) with_fronts: u32,
    pub(super) full_coverage: f32,
}

/// `Projector` in `project.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuProjector {
    first_pixel: [f32; 3],
    focal_ratio: f32,
    per_column: [f32; 3],
    per_footprint: f32,
    per_row: [f32; 3],
    padding_0: u32,
    origin: [f32; 3],
    padding_1: u32,
}

impl GpuProjector {
    /// Carries `source` into `target`.
    pub(super) fn new(source: &Camera, target: &Camera) -> Self {
        let projector = Projector::new(source, target);
        Self {
            first_pixel: projector.ray(0.0, 0.0).to_array(),
            focal_ratio: projector.focal_ratio,
            per_column: projector.per_column.to_array(),
            per_footprint: 1.0 / focal(source),
            per_row: projector.per_row.to_array(),
            padding_0: 0,
            origin: projector.origin.to_array(),
            padding_1: 0,
        }
    }
}

/// `View` in `lookup.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuView {
    pub(super) source_from_target: GpuProjector,
    pub(super) offset_in_world: [f32; 3],
    pub(super) tolerance: f32,
    pub(super) width: i32,
    pub(super) height: i32,
    pub(super) cells_across: u32,
    pub(super) first_cell: u32,
    pub(super) growth_along_offset: [f32; 3],
    pub(super) padding_0: u32,
}

/// `CellView` in `cell_view.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuCellView {
    pub(super) cells_from_target: GpuProjector,
    pub(super) across: u32,
    pub(super) down: u32,
    pub(super) first: u32,
    pub(super) behind_ratio: f32,
}

/// `CameraRays` in `sum_sky.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuCameraRays {
    pub(super) first: [f32; 3],
    pub(super) padding_0: u32,
    pub(super) across: [f32; 3],
    pub(super) padding_1: u32,
    pub(super) down: [f32; 3],
    pub(super) padding_2: u32,
}

/// `Finish` in `finish.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuFinish {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) step: u32,
    pub(super) view_count: u32,
    pub(super) first_ray: [f32; 3],
    pub(super) footprints: f32,
    pub(super) ray_across: [f32; 3],
    pub(super) focal: f32,
    pub(super) ray_down: [f32; 3],
    pub(super) with_fronts: u32,
    pub(super) tests_lines: u32,
    pub(super) with_coverage: u32,
    pub(super) padding_1: u32,
    pub(super) padding_2: u32,
}

/// `Piece` in `samples.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuPiece {
    pub(super) first_tile: u32,
    pub(super) camera: u32,
    pub(super) image: u32,
    pub(super) page: u32,
    pub(super) tiles_at: u32,
    pub(super) low_at: u32,
    pub(super) high_at: u32,
    pub(super) color_at: u32,
    /// 0 where no sample is doubtful.
    pub(super) doubtful_at: u32,
}

/// The words of a tile in `samples.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuTile {
    /// Column and row of the tile.
    pub(super) place: [u16; 2],
    pub(super) first: u32,
    pub(super) farthest: u32,
    pub(super) nearest: u32,
    pub(super) first_high: u32,
    /// Samples above each row.
    pub(super) before: [u8; 16],
    pub(super) rows: [u16; 16],
}

/// Words of a pixel's sums, as `SUM_WORDS` in `sums.wgsl`.
pub(super) const SUM_WORDS: u64 = 8;

/// Words of a pixel's key.
pub(super) const KEY_WORDS: u64 = 2;

/// Words of a pixel of the picture: color, inverse depth, image.
pub(super) const PICTURE_WORDS: u64 = 5;

/// Words of what a pixel shows in front of its farthest surface, where pictures tell it.
pub(super) const FRONT_WORDS: u64 = 5;

/// Words of the share of a pixel that is shown, between these.
pub(super) const COVERAGE_WORDS: u64 = 1;

/// Words of the surfaces of a pixel of the z-buffer, which the gather stage reads: two keys, and the share of the nearer one.
pub(super) const SURFACE_WORDS: u64 = 5;

/// Most cameras of the gather stage, as `CAMERA_WORDS` in `patch.wgsl` times 32.
pub(super) const MAX_CAMERAS: usize = 1024;

/// Workgroups in a row of a dispatch, as `GROUPS_ACROSS` in `stage.wgsl`.
pub(super) const GROUPS_ACROSS: u32 = 32768;

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;
    use crate::render::free_space::{CELL_BORDER, HOLE, OPEN_HOLE, SKY_HOLE};
    use crate::render::gpu::average::GpuAverage;
    use crate::render::gpu::display::GpuDisplay;
    use crate::render::gpu::finish::SKY_SIDE;
    use crate::render::gpu::shaders;
    use crate::render::gpu::upload::MASK_WORDS;
    use crate::settings::Kernel;
    use wgpu::naga;

    /// Size of a struct of the shaders, and the offset of each of its fields.
    fn in_shader(module: &naga::Module, name: &str) -> (u32, Vec<(String, u32)>) {
        let found = module.types.iter().find(|(_, kind)| kind.name.as_deref() == Some(name));
        let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
            panic!("no shader has a struct {name}");
        };
        (*span, members.iter().map(|member| (member.name.clone().unwrap(), member.offset)).collect())
    }

    fn constant(module: &naga::Module, name: &str) -> u32 {
        let (_, constant) =
            module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name)).unwrap();
        match module.global_expressions[constant.init] {
            naga::Expression::Literal(naga::Literal::U32(value)) => value,
            ref other => panic!("{name} is {other:?}"),
        }
    }

    fn float_constant(module: &naga::Module, name: &str) -> f32 {
        let (_, constant) =
            module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name)).unwrap();
        match module.global_expressions[constant.init] {
            naga::Expression::Literal(naga::Literal::F32(value)) => value,
            ref other => panic!("{name} is {other:?}"),
        }
    }

    macro_rules! assert_same_layout {
        ($module:expr, $name:literal, $kind:ty, $($field:ident),+) => {{
            let (size, fields) = in_shader($module, $name);
            assert_eq!(size as usize, size_of::<$kind>(), "size of {}", $name);
            let ours = [$((stringify!($field).to_owned(), offset_of!($kind, $field) as u32)),+];
            assert_eq!(fields, ours, "fields of {}", $name);
        }};
    }

    #[test]
    fn structs_lie_in_memory_as_shaders_read_them() {
        let module = naga::front::wgsl::parse_str(&shaders::GATHER.source()).unwrap();
        assert_same_layout! {
            &module, "Stage", GpuStage,
            width, height, kernel, step, first_tile, tile_count, piece_count, surface_ratio, first_ray,
            background_tiles, ray_across, entries_at, ray_down, all_tiles, pruned, subpixels, with_fronts, full_coverage
        }
        assert_same_layout! {
            &module, "View", GpuView,
            source_from_target, offset_in_world, tolerance, width, height, cells_across, first_cell,
            growth_along_offset, padding_0
        }
        assert_same_layout! {
            &module, "Piece", GpuPiece,
            first_tile, camera, image, page, tiles_at, low_at, high_at, color_at, doubtful_at
        }
        assert_same_layout! {
            &module, "Projector", GpuProjector,
            first_pixel, focal_ratio, per_column, per_footprint, per_row, padding_0, origin, padding_1
        }
    }

    #[test]
    fn what_the_finishing_stages_read_lies_as_they_expect() {
        let [_, lines_of_sight, ..] = shaders::FINISH;
        let module = naga::front::wgsl::parse_str(&lines_of_sight.source()).unwrap();
        assert_same_layout! {
            &module, "Finish", GpuFinish,
            width, height, step, view_count, first_ray, footprints, ray_across, focal, ray_down, with_fronts,
            tests_lines, with_coverage, padding_1, padding_2
        }
        assert_same_layout! {
            &module, "CellView", GpuCellView,
            cells_from_target, across, down, first, behind_ratio
        }
        assert_eq!(constant(&module, "BORDER") as usize, CELL_BORDER);
        assert_eq!(constant(&module, "NO_IMAGE"), crate::render::vantage::NO_IMAGE);
        assert_eq!(constant(&module, "GROUPS_ACROSS"), GROUPS_ACROSS);
        let marks = ["HOLE", "OPEN_HOLE", "SKY_HOLE"].map(|name| float_constant(&module, name));
        assert_eq!(marks, [HOLE, OPEN_HOLE, SKY_HOLE]);
        let module = naga::front::wgsl::parse_str(&shaders::AVERAGE.source()).unwrap();
        assert_same_layout! { &module, "Average", GpuAverage, width, height, factor, padding }
        let module = naga::front::wgsl::parse_str(&shaders::SUM_SKY.source()).unwrap();
        assert_same_layout! {
            &module, "CameraRays", GpuCameraRays,
            first, padding_0, across, padding_1, down, padding_2
        }
        assert_eq!(u64::from(constant(&module, "SKY_SIDE")), SKY_SIDE);
    }

    #[test]
    fn what_the_display_stage_reads_lies_as_it_expects() {
        let module = naga::front::wgsl::parse_str(&shaders::DISPLAY.source()).unwrap();
        assert_same_layout! {
            &module, "Display", GpuDisplay,
            width, height, stripe, padding, hole, hole_stripe
        }
        assert_eq!(constant(&module, "NO_IMAGE"), crate::render::vantage::NO_IMAGE);
    }

    #[test]
    fn constants_agree_with_those_of_the_shaders() {
        let module = naga::front::wgsl::parse_str(&shaders::BLEND.source()).unwrap();
        assert_eq!(constant(&module, "TILE_WORDS") as usize * 4, size_of::<GpuTile>());
        assert_eq!(constant(&module, "TILE_ROWS") as usize * 4, offset_of!(GpuTile, rows));
        assert_eq!(constant(&module, "TILE_BEFORE") as usize * 4, offset_of!(GpuTile, before));
        assert_eq!(constant(&module, "MASK_WORDS"), MASK_WORDS);
        assert_eq!(u64::from(constant(&module, "SUM_WORDS")), SUM_WORDS);
        assert_eq!(constant(&module, "GROUPS_ACROSS"), GROUPS_ACROSS);
        for kernel in Kernel::ALL {
            let name = format!("KERNEL_{}", kernel.name().to_uppercase());
            assert_eq!(constant(&module, &name), *kernel as u32);
        }
        let module = naga::front::wgsl::parse_str(&shaders::GATHER.source()).unwrap();
        assert_eq!(constant(&module, "CAMERA_WORDS") as usize * 32, MAX_CAMERAS);
        assert_eq!(constant(&module, "NO_IMAGE"), crate::render::vantage::NO_IMAGE);
    }
}
