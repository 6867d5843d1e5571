// The stage that makes a coarser grid of the sky; for the finest it reads sums in fixed point.
// Twin: `halved` in src/engine/render/environment.rs.

fn sum_of(cell: u32) -> vec4<f32> {
    let at = SUM_WORDS * cell;
    return vec4<f32>(
        floating_point(sums[at], sums[at + 1u]),
        floating_point(sums[at + 2u], sums[at + 3u]),
        floating_point(sums[at + 4u], sums[at + 5u]),
        floating_point(sums[at + 6u], sums[at + 7u]),
    );
}

@compute @workgroup_size(4, 4, 4)
fn halve_sky(@builtin(global_invocation_id) at: vec3<u32>) {
    let side = SKY_SIDE >> sky.level;
    if any(at >= vec3<u32>(side)) {
        return;
    }
    let cell = (at.z * side + at.y) * side + at.x;
    var sum = vec4<f32>(0.0);
    if sky.level == 0u {
        sum = sum_of(cell);
    } else {
        let finer_at = grid_at(sky.level - 1u);
        for (var corner = 0u; corner < 8u; corner++) {
            let part = 2u * at + vec3<u32>(corner & 1u, corner >> 1u & 1u, corner >> 2u);
            sum += grids[finer_at + (part.z * 2u * side + part.y) * 2u * side + part.x];
        }
    }
    grids[grid_at(sky.level) + cell] = sum;
}
