// The sky in a direction. Twin: src/engine/render/environment.rs.

// The color in a direction of length 1: trilinear, among the cells that touch the sphere.
fn sky_color(direction: vec3<f32>) -> vec3<f32> {
    let at = (direction + 1.0) * (0.5 * f32(SKY_SIDE)) - 0.5;
    let first = floor(at);
    let share = at - first;
    var sum = vec4<f32>(0.0);
    for (var corner = 0u; corner < 8u; corner++) {
        let step = vec3<u32>(corner & 1u, corner >> 1u & 1u, corner >> 2u);
        let cell = vec3<u32>(clamp(vec3<i32>(first) + vec3<i32>(step), vec3<i32>(0), vec3<i32>(i32(SKY_SIDE) - 1)));
        let part = select(1.0 - share, share, step == vec3<u32>(1u));
        sum += part.x * part.y * part.z * environment[(cell.z * SKY_SIDE + cell.y) * SKY_SIDE + cell.x];
    }
    return sum.xyz / sum.w;
}

// The color of the sky in a pixel.
fn sky_at(at: vec2<u32>) -> vec3<f32> {
    let line = finish.first_ray + finish.ray_across * f32(at.x) + finish.ray_down * f32(at.y);
    return sky_color(normalize(line));
}
