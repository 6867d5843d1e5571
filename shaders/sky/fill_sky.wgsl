// The stage that colors a grid of the sky: by its samples where it has enough, else from the coarser grid.
// Twin: `filled` in src/engine/render/environment.rs.

// A cell with fewer samples than this takes the missing share from the coarser grid.
const FULL_COUNT: f32 = 16.0;
const COARSEST: u32 = 6u;

// Whether the unit sphere goes through a cell.
fn touches_sphere(center: vec3<f32>, half_width: f32) -> bool {
    let nearest = length(max(abs(center) - half_width, vec3<f32>(0.0)));
    let farthest = length(abs(center) + half_width);
    return nearest <= 1.0 && 1.0 <= farthest;
}

// The color in a direction of length 1, or no direction, in a grid of `side` cells along each side: trilinear, among the cells that touch
// the sphere.
fn interpolated(grid: u32, side: u32, direction: vec3<f32>) -> vec3<f32> {
    let at = (direction + 1.0) * (0.5 * f32(side)) - 0.5;
    let first = floor(at);
    let share = at - first;
    var sum = vec4<f32>(0.0);
    for (var corner = 0u; corner < 8u; corner++) {
        let step = vec3<u32>(corner & 1u, corner >> 1u & 1u, corner >> 2u);
        let cell = vec3<u32>(clamp(vec3<i32>(first) + vec3<i32>(step), vec3<i32>(0), vec3<i32>(i32(side) - 1)));
        let part = select(1.0 - share, share, step == vec3<u32>(1u));
        sum += part.x * part.y * part.z * environment[grid + (cell.z * side + cell.y) * side + cell.x];
    }
    return sum.xyz / sum.w;
}

@compute @workgroup_size(4, 4, 4)
fn fill_sky(@builtin(global_invocation_id) at: vec3<u32>) {
    let side = SKY_SIDE >> sky.level;
    if any(at >= vec3<u32>(side)) {
        return;
    }
    let place = grid_at(sky.level) + (at.z * side + at.y) * side + at.x;
    let sum = grids[place];
    if sky.level == COARSEST {
        // Behind the coarsest grid, which has one cell.
        environment[place + 1u] = sum;
    }
    let half_width = 1.0 / f32(side);
    let center = vec3<f32>(2u * at + 1u) * half_width - 1.0;
    if sum.w == 0.0 && !touches_sphere(center, half_width) {
        environment[place] = vec4<f32>(0.0);
        return;
    }
    let full = select(min(sum.w / FULL_COUNT, 1.0), 1.0, sky.level == COARSEST);
    var color = vec3<f32>(0.0);
    if sum.w > 0.0 {
        color = full * (sum.xyz / sum.w);
    }
    if full < 1.0 {
        let direction = center / max(length(center), 1e-30);
        color += (1.0 - full) * interpolated(grid_at(sky.level + 1u), side / 2u, direction);
    }
    environment[place] = vec4<f32>(color, 1.0);
}
