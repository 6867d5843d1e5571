// Pixels of the z-buffer within footprints. Twin: src/engine/render/geometry/footprint.rs.

// Columns and rows `[left, right, top, bottom]`, whole numbers, all inclusive.
fn edges_around(pixel: vec2<f32>, half_size: vec2<f32>) -> vec4<i32> {
    return edges_between(pixel - half_size, pixel + half_size);
}

// The same between two corners.
fn edges_between(first: vec2<f32>, last: vec2<f32>) -> vec4<i32> {
    let low = max(ceil(first - 0.5), vec2<f32>(0.0));
    let high = min(floor(last - 0.5), vec2<f32>(f32(stage.width), f32(stage.height)) - 1.0);
    return vec4<i32>(i32(low.x), i32(high.x), i32(low.y), i32(high.y));
}
