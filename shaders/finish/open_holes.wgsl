// The stage that marks holes that nothing encloses, in squares of 4×4 pixels, one thread each.
// Twin: `mark_of_open_hole` in src/engine/render/free_space/hidden.rs.

const COARSE: u32 = 4u;

fn mark_of_open_hole(at: vec2<u32>) -> f32 {
    let range = range_around(at);
    if range.x == 0.0 {
        return SKY_HOLE;
    }
    let line = test_line(vec2<f32>(at + COARSE / 2u), range.x, range.y * BEYOND_FARTHEST);
    switch line.kind {
        case FREE: { return SKY_HOLE; }
        case HIDDEN: { return OPEN_HOLE; }
        default: { return HOLE; }
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
        planes[pixel_count() + at.y * finish.width + at.x] = mark;
    }
}
