// The stage that tells how far the lines of sight of cameras are free at the corners between their cells.
// Twin: `CellDepths::find_free` in src/engine/render/free_space/seen_depth.rs.

@group(1) @binding(0) var<storage, read> views: array<CellView>;
@group(1) @binding(1) var<storage, read> nearest: array<u32>;
@group(1) @binding(2) var<storage, read_write> farthest: array<f32>;

// The inverse depth of a cell; UNSEEN where nothing was seen.
fn seen_at(bits: u32) -> f32 {
    return select(bitcast<f32>(bits - 1u), UNSEEN, bits == 0u);
}

@compute @workgroup_size(16, 16)
fn free_depths(@builtin(global_invocation_id) at: vec3<u32>) {
    let view = views[at.z];
    let corners = vec2<u32>(view.across, view.down) - 1u;
    if at.x >= corners.x || at.y >= corners.y {
        return;
    }
    let above = view.first + at.y * view.across + at.x;
    let below = above + view.across;
    let left = min(seen_at(nearest[above]), seen_at(nearest[below]));
    let right = min(seen_at(nearest[above + 1u]), seen_at(nearest[below + 1u]));
    farthest[view.first + at.y * corners.x + at.x] = min(left, right);
}
