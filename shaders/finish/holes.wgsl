// The stage that turns marked pixels into holes, and counts all holes. Twin: `mark_holes` in src/engine/render/free_space/hidden.rs.

@compute @workgroup_size(16, 16)
fn holes(@builtin(global_invocation_id) at: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    begin_tally(thread);
    if at.x < finish.width && at.y < finish.height {
        let pixel = at.y * finish.width + at.x;
        if knows_sky() && mark_at(pixel) != SHOWN {
            set_color(pixel, vec3<f32>(0.0));
            set_depth(pixel, mark_at(pixel));
            picture[4u * pixel_count() + pixel] = NO_IMAGE;
        }
        count_if(image_at(pixel) == NO_IMAGE, HOLES);
        count_if(depth_at(pixel) == OPEN_HOLE, OPEN_HOLES);
    }
    end_tally(thread);
}
