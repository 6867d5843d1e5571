// The stage that marks holes that nothing encloses, in squares of 4×4 pixels, one thread each.
// Twin: `mark_of_open_hole` in src/engine/render/free_space/hidden.rs.

const COARSE: u32 = 4u;

// The mark of holes, and the share of their line of sight that is hidden.
fn mark_of_open_hole(at: vec2<u32>) -> vec2<f32> {
    let range = range_around(at);
    if range.x == 0.0 {
        return vec2<f32>(SKY_HOLE, 0.0);
    }
    let line = test_line(vec2<f32>(at + COARSE / 2u), range.x, range.y * BEYOND_FARTHEST);
    switch line.kind {
        case FREE: { return vec2<f32>(SKY_HOLE, 0.0); }
        case HIDDEN: { return vec2<f32>(OPEN_HOLE, line.share); }
        default: { return vec2<f32>(HOLE, 0.0); }
    }
}

@compute @workgroup_size(8, 8)
fn open_holes(@builtin(global_invocation_id) square: vec3<u32>) {
    let first = square.xy * COARSE;
    if first.x >= finish.width || first.y >= finish.height || !knows_sky() {
        return;
    }
    var open = 0u;
    for (var nth = 0u; nth < COARSE * COARSE; nth++) {
        let at = first + vec2<u32>(nth % COARSE, nth / COARSE);
        if at.x < finish.width && at.y < finish.height {
            let pixel = at.y * finish.width + at.x;
            open |= select(0u, 1u << nth, image_at(pixel) == NO_IMAGE && mark_at(pixel) == SHOWN);
        }
    }
    if open == 0u {
        return;
    }
    let mark = mark_of_open_hole(first);
    for (; open != 0u; open &= open - 1u) {
        let nth = firstTrailingBit(open);
        let at = first + vec2<u32>(nth % COARSE, nth / COARSE);
        let pixel = at.y * finish.width + at.x;
        planes[pixel_count() + pixel] = mark.x;
        planes[hidden_share_at(pixel)] = mark.y;
    }
}
