// The stage that tells open holes that see some of the sky, and through which no surface goes on, from others.
// Twin: `is_open_to_sky` in src/engine/render/fill/mod.rs.

// Surfaces that face each other across a hole in more of the four directions go on through it.
const MOST_FACING: u32 = 1u;

fn is_open_to_sky(at: vec2<u32>) -> bool {
    var seen = neighbors_of(SOURCES_OF_OPEN, at);
    var surfaces = 0u;
    var sees_sky = false;
    var sees_nothing = true;
    for (var direction = 0u; direction < 8u; direction++) {
        if seen.distance[direction] < NONE {
            let w = depth_at(seen.pixel[direction]);
            surfaces |= select(0u, 1u << direction, w > 0.0);
            sees_sky |= w == 0.0;
            sees_nothing = false;
        }
    }
    let facing = countOneBits(surfaces & surfaces >> 4u);
    return sees_nothing || (sees_sky && facing <= MOST_FACING);
}

@compute @workgroup_size(16, 16)
fn open_sky(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= finish.width || at.y >= finish.height || !knows_sky() || !is_asked(SOURCES_OF_OPEN) {
        return;
    }
    let pixel = at.y * finish.width + at.x;
    if depth_at(pixel) == OPEN_HOLE && !is_open_to_sky(at.xy) {
        planes[hidden_share_at(pixel)] *= -1.0;
    }
}
