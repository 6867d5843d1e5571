// The stage that joins neighbors in holes: means of what fills them, along rows and then along columns.
// Twin: src/engine/render/fill/around.rs.

// Means reach this share of the picture's width to each side.
const REACH: f32 = 0.0078125;

fn reach() -> u32 {
    return max(u32(f32(finish.width) * REACH), 1u);
}

fn sum_row(at: vec2<u32>, pixel: u32) {
    var colors = vec4<f32>(0.0);
    var shares = vec2<f32>(0.0);
    let last = min(at.x + reach(), finish.width - 1u);
    for (var x = max(at.x, reach()) - reach(); x <= last; x++) {
        let there = at.y * finish.width + x;
        let share = sky_share_of(there);
        if share >= 0.0 {
            shares += vec2<f32>(min(share, 1.0), 1.0);
            colors += select(vec4<f32>(color_at(there), 1.0), vec4<f32>(0.0), share == ONLY_SKY);
        }
    }
    let place = sums_at(pixel);
    masks[place] = bitcast<u32>(colors.x);
    masks[place + 1u] = bitcast<u32>(colors.y);
    masks[place + 2u] = bitcast<u32>(colors.z);
    masks[place + 3u] = bitcast<u32>(colors.w);
    masks[place + 4u] = bitcast<u32>(shares.x);
    masks[place + 5u] = bitcast<u32>(shares.y);
}

// Whether any of the eight pixels around one shows a sample.
fn is_beside_shown(at: vec2<u32>) -> bool {
    for (var y = max(at.y, 1u) - 1u; y <= min(at.y + 1u, finish.height - 1u); y++) {
        for (var x = max(at.x, 1u) - 1u; x <= min(at.x + 1u, finish.width - 1u); x++) {
            if image_at(y * finish.width + x) != NO_IMAGE {
                return true;
            }
        }
    }
    return false;
}

fn set_mean(at: vec2<u32>, pixel: u32) {
    var colors = vec4<f32>(0.0);
    var shares = vec2<f32>(0.0);
    let last = min(at.y + reach(), finish.height - 1u);
    for (var y = max(at.y, reach()) - reach(); y <= last; y++) {
        let there = y * finish.width + at.x;
        if sky_share_of(there) >= 0.0 {
            let place = sums_at(there);
            colors += vec4<f32>(
                bitcast<f32>(masks[place]),
                bitcast<f32>(masks[place + 1u]),
                bitcast<f32>(masks[place + 2u]),
                bitcast<f32>(masks[place + 3u]),
            );
            shares += vec2<f32>(bitcast<f32>(masks[place + 4u]), bitcast<f32>(masks[place + 5u]));
        }
    }
    // Beside what is shown the choice is sure.
    let color = select(colors.xyz / colors.w, color_at(pixel), is_beside_shown(at));
    let share = shares.x / shares.y;
    set_color(pixel, color);
    if knows_sky() && share > 0.0 {
        set_color(pixel, color + share * (sky_at(at) - color));
        if share >= 0.5 {
            set_depth(pixel, 0.0);
        }
    }
}

@compute @workgroup_size(16, 16)
fn around(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= finish.width || at.y >= finish.height || !has_filling() {
        return;
    }
    let pixel = at.y * finish.width + at.x;
    let share = sky_share_of(pixel);
    if share == NOT_FILLED {
        return;
    }
    if finish.step == 0u {
        sum_row(at.xy, pixel);
    } else if share != ONLY_SKY {
        set_mean(at.xy, pixel);
    }
}
