// The stage that turns marked pixels into holes, counts all holes, and keeps the colors of pixels that are shown in part.
// Twins: `mark_holes` in src/engine/render/free_space/hidden.rs, `PartialPixels::take` in src/engine/render/fill/partial.rs.

@compute @workgroup_size(16, 16)
fn holes(@builtin(global_invocation_id) at: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    begin_tally(thread);
    if at.x < finish.width && at.y < finish.height {
        let pixel = at.y * finish.width + at.x;
        if knows_sky() && mark_at(pixel) != SHOWN {
            set_depth(pixel, mark_at(pixel));
            picture[4u * pixel_count() + pixel] = NO_IMAGE;
        }
        if is_partial(pixel) {
            let color = color_at(pixel);
            let at = kept_at(pixel);
            planes[at] = color.x;
            planes[at + 1u] = color.y;
            planes[at + 2u] = color.z;
        }
        count_if(image_at(pixel) == NO_IMAGE, HOLES);
        count_if(depth_at(pixel) == OPEN_HOLE, OPEN_HOLES);
    }
    end_tally(thread);
}
