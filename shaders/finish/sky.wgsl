// The stage that fills holes whose line of sight is free with the sky. Twin: `fill_sky` in src/engine/render/fill/mod.rs.

@compute @workgroup_size(16, 16)
fn sky(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= finish.width || at.y >= finish.height || !knows_sky() || !has_filling() {
        return;
    }
    let pixel = at.y * finish.width + at.x;
    if depth_at(pixel) == SKY_HOLE {
        set_color(pixel, sky_at(at.xy));
        set_depth(pixel, 0.0);
    }
}
