// The stage that marks pixels that nearer surfaces enclose and whose line of sight is hidden. Where such a pixel shows something in
// front of its farthest surface, it shows that alone. Twins: `MarkSquares` and `show_fronts` in src/engine/render/free_space/hidden.rs.

// Directions that must lead to a nearer surface.
const ENOUGH: u32 = 7u;

// Whether enough directions lead from a pixel over hidden ones to a surface nearer than `w`, or out of the picture.
fn is_enclosed(at: vec2<i32>, w: f32) -> bool {
    let limit = w * NEARER;
    let reach = reach();
    var missing = 0u;
    for (var nth = 0u; nth < 8u; nth++) {
        var is_found = false;
        for (var step = 1; step <= reach; step++) {
            let there = at + DIRECTIONS[nth] * step;
            is_found = shown_at(there) > limit;
            // Beyond the picture every surface counts as nearer.
            if is_found || planes[u32(there.y) * finish.width + u32(there.x)] < 0.0 {
                break;
            }
        }
        missing += select(1u, 0u, is_found);
        if missing > 8u - ENOUGH {
            return false;
        }
    }
    return true;
}

@compute @workgroup_size(16, 16)
fn enclosed(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= finish.width || at.y >= finish.height || !knows_sky() {
        return;
    }
    let pixel = at.y * finish.width + at.x;
    let hidden_until = planes[pixel];
    var mark = SHOWN;
    if hidden_until >= 0.0 {
        let here = vec2<i32>(at.xy);
        if is_enclosed(here, farthest_shown(pixel, shown_at(here))) {
            mark = HOLE - hidden_until;
            if farthest_shown(pixel, shown_at(here)) > 0.0 {
                planes[hidden_share_at(pixel)] = 0x1.fffffep+127f;
            }
            if image_at(pixel) != NO_IMAGE {
                let front = front_at(pixel);
                let share = select(0.0, front_share_at(pixel), front.w >= 0.0);
                if share >= LEAST_SHOWN {
                    mark = SHOWN;
                }
                let is_shown = share > 0.0 && (mark == SHOWN || finish.with_coverage != 0u);
                set_color(pixel, select(vec3<f32>(0.0), front.xyz, is_shown));
                picture[5u * pixel_count() + pixel] = bitcast<u32>(share);
            }
        }
    }
    planes[pixel_count() + pixel] = mark;
}
