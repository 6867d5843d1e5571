// The stage that counts the kinds of holes that are left to be filled, and what they may be filled from.
// Twin: `fill_from` in src/engine/render/fill/mod.rs.

@compute @workgroup_size(16, 16)
fn kinds(@builtin(global_invocation_id) at: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    begin_tally(thread);
    if at.x < finish.width && at.y < finish.height {
        let pixel = at.y * finish.width + at.x;
        let w = depth_at(pixel);
        count_if(w < 0.0 && w >= HOLE, PLAIN_HOLES);
        count_if(w < HOLE, HIDING_HOLES);
        if knows_sky() {
            count_if(w > 0.0, SURFACES);
            count_if(w > 0.0 && planes[pixel] == 1.0, BLENDED_SURFACES);
        }
    }
    end_tally(thread);
}
