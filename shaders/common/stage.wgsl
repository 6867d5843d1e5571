// What the stages of one picture share, and z-buffer keys. Twins: `StageInput` in src/engine/render/splat/input.rs,
// src/engine/render/splat/zkey.rs.
//
// A key takes two words, the lower half first: [u32::MAX − slot, core | trusted | nearness]; both are 0 where there is nothing.

struct Stage {
    // Size of the z-buffer, pixels.
    width: u32,
    height: u32,
    // See KERNEL_*.
    kernel: u32,
    // Which of two passes over the samples this is; used where keys are raised half by half.
    step: u32,
    // Numbers of the tiles that are painted: `tile_count` of them from `first_tile` on.
    first_tile: u32,
    tile_count: u32,
    // Entries of `pieces`.
    piece_count: u32,
    // Inverse depths from this share of the nearest one on belong to the same surface.
    surface_ratio: f32,
    // World-space ray of the center of the z-buffer's first pixel, and its growth by column and row.
    first_ray: vec3<f32>,
    // Tiles of the background.
    background_tiles: u32,
    ray_across: vec3<f32>,
    // Where the entries begin in `lookup`.
    entries_at: u32,
    ray_down: vec3<f32>,
    // Tiles of the frame.
    all_tiles: u32,
    // 1 if redundant samples were pruned.
    pruned: u32,
    // Pixels of the z-buffer along each side of a pixel of the picture: 1, or 2 for the gather kernel.
    subpixels: u32,
    // 1 if pictures tell what pixels show in front of their farthest surface.
    with_fronts: u32,
    // No further camera is read once this many pixels' worth of samples are found.
    full_coverage: f32,
}

@group(0) @binding(0) var<uniform> stage: Stage;

const KERNEL_POINT: u32 = 0u;
const KERNEL_BLOCK: u32 = 1u;
const KERNEL_SURFEL: u32 = 2u;
const KERNEL_GATHER: u32 = 3u;

// Pixels of the picture.
fn picture_pixels() -> u32 {
    return (stage.width / stage.subpixels) * (stage.height / stage.subpixels);
}

// Words of a pixel of the picture.
fn picture_words() -> u32 {
    return 6u + 5u * stage.with_fronts;
}

// Workgroups in a row of a dispatch; further ones go into further rows, as one dimension holds 65535 at most.
const GROUPS_ACROSS: u32 = 32768u;

// Marks a core sample, in the upper half of a key.
const CORE: u32 = 0x80000000u;

// Marks a sample that is not doubtful.
const TRUSTED: u32 = 0x40000000u;

// See the twin.
const FARTHEST: i32 = 0x1f800000;
const NEAREST: i32 = 0x5f7ffffe;

// The upper half of a key.
fn nearness(inverse_depth: f32, tier: u32) -> u32 {
    return u32(clamp(bitcast<i32>(inverse_depth), FARTHEST, NEAREST) - (FARTHEST - 1)) | tier;
}

// The inverse depth of the upper half of a key; negative for 0.
fn inverse_depth_of(upper: u32) -> f32 {
    let nearness = upper & ~(CORE | TRUSTED);
    if nearness <= 1u {
        return select(0.0, -1.0, nearness == 0u);
    }
    return bitcast<f32>(nearness + u32(FARTHEST - 1));
}
