// The stage that finds the nearest and the farthest surface in each square of 16×16 pixels.
// Twin: `ranges` in src/engine/render/free_space/surroundings.rs.

var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;

@compute @workgroup_size(16, 16)
fn square_ranges(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if thread == 0u {
        atomicStore(&nearest, 0u);
        atomicStore(&farthest, bitcast<u32>(OUTSIDE));
    }
    workgroupBarrier();
    if at.x < finish.width && at.y < finish.height {
        let w = depth_at(at.y * finish.width + at.x);
        if w > 0.0 {
            atomicMax(&nearest, bitcast<u32>(w));
            atomicMin(&farthest, bitcast<u32>(w));
        }
    }
    workgroupBarrier();
    if thread == 0u {
        let range = vec2<f32>(bitcast<f32>(atomicLoad(&nearest)), bitcast<f32>(atomicLoad(&farthest)));
        squares[group.y * squares_across() + group.x] = range;
    }
}
