// The surface stage: which sample is nearest in each pixel. Twin: src/render/surface.rs.
//
// One workgroup a tile of samples, one thread a sample. What the CPU paints in blocks of sixteen and four corners is a plain
// loop over the pixels of a footprint here; the maximum makes the order irrelevant.

// A sample belongs to the core of a pixel that gets at least this share of it by bilinear weights, and else to its fringe.
const CORE_SHARE: f32 = 0.06;

fn raise_point(projected: Projected, w: f32, slot: u32) {
    let place = floor(projected.pixel);
    if all(place >= vec2<f32>(0.0)) && place.x < f32(stage.width) && place.y < f32(stage.height) {
        raise(u32(place.y) * stage.width + u32(place.x), nearness(w * projected.reciprocal, CORE), slot);
    }
}

fn raise_block(projected: Projected, w: f32, slot: u32) {
    let corner = floor(projected.pixel - 0.5);
    let share = projected.pixel - 0.5 - corner;
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(f32(i & 1u), f32(i >> 1u));
        let place = corner + step;
        if all(place >= vec2<f32>(0.0)) && place.x < f32(stage.width) && place.y < f32(stage.height) {
            let shares = select(1.0 - share, share, step > vec2<f32>(0.5));
            let tier = select(0u, CORE, shares.x * shares.y >= CORE_SHARE);
            raise(u32(place.y) * stage.width + u32(place.x), nearness(w * projected.reciprocal, tier), slot);
        }
    }
}

fn raise_footprint(projected: Projected, found: Footprint, slot: u32) {
    let edges = edges_around(projected.pixel, max(found.half_size, vec2<f32>(0.5)));
    for (var y = edges.z; y <= edges.w; y++) {
        for (var x = edges.x; x <= edges.y; x++) {
            let off = vec2<f32>(f32(x), f32(y)) + 0.5 - projected.pixel;
            let across = found.inverse.x * off.x + found.inverse.y * off.y;
            let down = found.inverse.z * off.x + found.inverse.w * off.y;
            let covered = max(abs(across), abs(down)) <= 0.5 * OVERLAP || max(abs(off.x), abs(off.y)) <= 0.5;
            if covered {
                let deviation = clamp(
                    found.slope.x * off.x + found.slope.y * off.y,
                    -found.deviation,
                    found.deviation,
                );
                let depth = max(found.inverse_depth + deviation, 0.0);
                raise(u32(y) * stage.width + u32(x), nearness(depth, CORE), slot);
            }
        }
    }
}

@compute @workgroup_size(16, 16)
fn surface(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let nth = group.y * GROUPS_ACROSS + group.x;
    if nth >= stage.tile_count {
        return;
    }
    let number = stage.first_tile + nth;
    let piece = pieces[piece_of(number)];
    let pixel = lay_out(piece, number, local.xy);
    let w = pixel.inverse_depth;
    let projector = projectors[piece.camera];
    let projected =
        project(projector, pixel.corner.x, pixel.corner.y + f32(local.y), f32(local.x), w);
    if w < 0.0 || !is_seen(projected) {
        return;
    }
    let slot = number << 8u | local.y << 4u | local.x;
    switch stage.kernel {
        case KERNEL_POINT: { raise_point(projected, w, slot); }
        case KERNEL_BLOCK: { raise_block(projected, w, slot); }
        default: {
            let found = footprint(projector, projected, w, slopes(local.xy, projector.per_footprint));
            raise_footprint(projected, found, slot);
        }
    }
}
