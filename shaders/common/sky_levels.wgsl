// What the stages that make grids of the sky of each other share.

struct SkyLevel {
    // Which grid is made, the finest 0.
    level: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> sky: SkyLevel;
@group(0) @binding(1) var<storage, read> sums: array<u32>;
// Weighted sums of red, green and blue, and the sum of weights, of all grids.
@group(0) @binding(2) var<storage, read_write> grids: array<vec4<f32>>;
// Red, green, blue and 1 of all grids; zeros in cells that do not touch the sphere. Behind them, how often the sky was seen.
@group(0) @binding(3) var<storage, read_write> environment: array<vec4<f32>>;

// Where a grid begins.
fn grid_at(level: u32) -> u32 {
    var at = 0u;
    for (var nth = 0u; nth < level; nth++) {
        let side = SKY_SIDE >> nth;
        at += side * side * side;
    }
    return at;
}
