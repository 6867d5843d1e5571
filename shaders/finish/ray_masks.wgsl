// The stage that tells by a bit a pixel which are sources, along lines of four kinds. One thread a word.
// Twin: `HoleRays::cast` in src/engine/render/fill/rays.rs.

// The word whose first pixel is `at`, and each next one a step further.
fn mask_of(set_of: u32, at: vec2<i32>, step: vec2<i32>) -> u32 {
    var mask = 0u;
    for (var nth = 0; nth < 32; nth++) {
        let there = at + nth * step;
        if there.x >= 0 && there.x < i32(finish.width) && there.y < i32(finish.height) {
            let pixel = u32(there.y) * finish.width + u32(there.x);
            mask |= select(0u, 1u << u32(nth), is_source(set_of, pixel));
        }
    }
    return mask;
}

@compute @workgroup_size(256)
fn ray_masks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let set_of = finish.step + group.z;
    let words = mask_words();
    var nth = (group.y * GROUPS_ACROSS + group.x) * 256u + thread;
    if nth >= words.x + words.y + words.z + words.w || !is_asked(set_of) {
        return;
    }
    let place = masks_at(set_of) + nth;
    let across = (finish.width + 31u) / 32u;
    let slanted = finish.width + finish.height - 1u;
    if nth < words.x {
        masks[place] = mask_of(set_of, vec2<i32>(i32(nth % across) * 32, i32(nth / across)), vec2<i32>(1, 0));
        return;
    }
    nth -= words.x;
    if nth < words.y {
        masks[place] = mask_of(set_of, vec2<i32>(i32(nth % finish.width), i32(nth / finish.width) * 32), vec2<i32>(0, 1));
        return;
    }
    nth -= words.y;
    let is_falling_left = nth >= words.z;
    nth -= select(0u, words.z, is_falling_left);
    let row = i32(nth / slanted) * 32;
    let line = i32(nth % slanted);
    let column = select(line - (i32(finish.height) - 1) + row, line - row, is_falling_left);
    masks[place] = mask_of(set_of, vec2<i32>(column, row), vec2<i32>(select(1, -1, is_falling_left), 1));
}
