// The stage that puts what is shown of pixels in part over what fills the rest: first in pixels that count as shown, whose rest is
// filled as the holes beside them are, then in holes. Twin: `PartialPixels::put_over` in src/engine/render/fill/partial.rs.

fn is_filled(pixel: u32) -> bool {
    return image_at(pixel) == NO_IMAGE && depth_at(pixel) >= 0.0;
}

// Sum of the colors that fill the holes beside a pixel, and their number.
fn filling_beside(at: vec2<u32>) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
    for (var y = max(at.y, 1u) - 1u; y <= min(at.y + 1u, finish.height - 1u); y++) {
        for (var x = max(at.x, 1u) - 1u; x <= min(at.x + 1u, finish.width - 1u); x++) {
            let there = y * finish.width + x;
            if is_filled(there) {
                sum += vec4<f32>(color_at(there), 1.0);
            }
        }
    }
    return sum;
}

@compute @workgroup_size(16, 16)
fn put_over(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= finish.width || at.y >= finish.height {
        return;
    }
    let pixel = at.y * finish.width + at.x;
    let is_hole = image_at(pixel) == NO_IMAGE;
    if !has_filling() {
        // What covers less than half of a pixel is not shown without anything that fills the rest.
        if is_hole {
            set_color(pixel, vec3<f32>(0.0));
        }
        return;
    }
    if !is_partial(pixel) || is_hole != (finish.step == 1u) {
        return;
    }
    var below: vec4<f32>;
    if is_hole {
        below = vec4<f32>(color_at(pixel), select(0.0, 1.0, is_filled(pixel)));
    } else {
        below = filling_beside(at.xy);
    }
    if below.w == 0.0 {
        return;
    }
    let behind = below.xyz / below.w;
    let share = bitcast<f32>(picture[5u * pixel_count() + pixel]);
    let kept = kept_at(pixel);
    let color = vec3<f32>(planes[kept], planes[kept + 1u], planes[kept + 2u]);
    set_color(pixel, behind + share * (color - behind));
}
