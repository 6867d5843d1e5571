// The stage that gives shown pixels beside those that were turned into holes a color that is not blended with what was there.
// Twin: `unblended` in src/engine/render/free_space/hidden.rs.

// Whether a pixel that a sample reached was turned into a hole.
fn was_turned(pixel: u32) -> bool {
    return image_at(pixel) != NO_IMAGE && mark_at(pixel) != SHOWN;
}

// Columns and rows `[left, right, top, bottom]` around a pixel, inclusive, as far as they are in the picture.
fn edges_around(at: vec2<u32>) -> vec4<u32> {
    let right = min(at.x + 1u, finish.width - 1u);
    let below = min(at.y + 1u, finish.height - 1u);
    return vec4<u32>(max(at.x, 1u) - 1u, right, max(at.y, 1u) - 1u, below);
}

fn is_rim(at: vec2<u32>) -> bool {
    let edges = edges_around(at);
    for (var y = edges.z; y <= edges.w; y++) {
        for (var x = edges.x; x <= edges.y; x++) {
            if was_turned(y * finish.width + x) {
                return true;
            }
        }
    }
    return false;
}

@compute @workgroup_size(16, 16)
fn rims(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= finish.width || at.y >= finish.height || !knows_sky() {
        return;
    }
    let pixel = at.y * finish.width + at.x;
    planes[pixel] = 0.0;
    if image_at(pixel) == NO_IMAGE || mark_at(pixel) != SHOWN || !is_rim(at.xy) {
        return;
    }
    let own = depth_at(pixel);
    let tolerance = 1.0 + (finish.footprints + 1.0) / finish.focal;
    var sum = vec3<f32>(0.0);
    var count = 0.0;
    let edges = edges_around(at.xy);
    for (var y = edges.z; y <= edges.w; y++) {
        for (var x = edges.x; x <= edges.y; x++) {
            let there = y * finish.width + x;
            let w = depth_at(there);
            let is_same = max(w, own) <= min(w, own) * tolerance;
            if is_same && image_at(there) != NO_IMAGE && mark_at(there) == SHOWN && !is_rim(vec2<u32>(x, y)) {
                sum += color_at(there);
                count += 1.0;
            }
        }
    }
    if count > 0.0 {
        set_color(pixel, sum / count);
    } else {
        planes[pixel] = 1.0;
    }
}
