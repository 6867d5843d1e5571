// The stage that sums up the colors of samples at infinity by direction. One workgroup a tile.
// Twin: `SkySums::new` in src/engine/render/environment.rs.

// World-space ray of the center of a camera's first pixel, and its growth by column and row.
struct CameraRays {
    first: vec3<f32>,
    padding_0: u32,
    across: vec3<f32>,
    padding_1: u32,
    down: vec3<f32>,
    padding_2: u32,
}

@group(1) @binding(0) var<storage, read> camera_rays: array<CameraRays>;
@group(1) @binding(1) var<storage, read_write> sums: array<atomic<u32>>;

// Weight of a sample with a missing neighbor.
const BESIDE_MISSING: f32 = 0.015625;

// Weight of a sample: zero unless it is at infinity with no surface beside it.
fn weight_of_sky(at: vec2<u32>) -> f32 {
    var nearest = 0.0;
    var farthest = 0.0;
    for (var row = max(at.y, 1u) - 1u; row <= min(at.y + 1u, TILE - 1u); row++) {
        for (var column = max(at.x, 1u) - 1u; column <= min(at.x + 1u, TILE - 1u); column++) {
            let w = tile_inverse_depth[row * TILE + column];
            nearest = max(nearest, w);
            farthest = min(farthest, w);
        }
    }
    return select(select(1.0, BESIDE_MISSING, farthest < 0.0), 0.0, nearest > 0.0);
}

fn add_part(at: u32, value: f32) {
    let part = fixed_point(value);
    let before = atomicAdd(&sums[at], part.x);
    let carried = part.y + select(0u, 1u, before + part.x < before);
    if carried != 0u {
        atomicAdd(&sums[at + 1u], carried);
    }
}

@compute @workgroup_size(16, 16)
fn sum_sky(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let nth = group.y * GROUPS_ACROSS + group.x;
    if nth >= stage.tile_count {
        return;
    }
    let number = stage.first_tile + nth;
    let piece = pieces[piece_of(number)];
    // Tiles whose farthest sample is a surface.
    if word(piece.page, tile_at(piece, number) + 2u) != 0u {
        return;
    }
    let pixel = lay_out(piece, number, local.xy);
    if pixel.inverse_depth != 0.0 {
        return;
    }
    let weight = weight_of_sky(local.xy);
    if weight == 0.0 {
        return;
    }
    let rays = camera_rays[piece.camera];
    let at = pixel.corner + vec2<f32>(local.xy);
    let direction = normalize(rays.first + rays.across * at.x + rays.down * at.y);
    let cell = min(vec3<u32>((direction + 1.0) * (0.5 * f32(SKY_SIDE))), vec3<u32>(SKY_SIDE - 1u));
    let color = clamp(unpack_color(piece, pixel.index), vec3<f32>(-LARGEST_HALF), vec3<f32>(LARGEST_HALF));
    let place = SUM_WORDS * ((cell.z * SKY_SIDE + cell.y) * SKY_SIDE + cell.x);
    add_part(place, color.x * weight);
    add_part(place + 2u, color.y * weight);
    add_part(place + 4u, color.z * weight);
    add_part(place + 6u, weight);
}
