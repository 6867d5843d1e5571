// The surface stage: which sample is nearest in each pixel. Twin: src/render/surface.rs.
//
// One workgroup a tile of samples, one thread a sample. What the CPU paints in blocks of sixteen and four corners is a plain
// loop over the pixels of a footprint here; the maximum makes the order irrelevant. Footprints of very many pixels are painted
// by all threads of the workgroup together.

// Footprints of more pixels are shared: one thread would be long over what the others wait for, and some adapters end loops of
// 65,536 steps.
const SHARED_FROM: u32 = 1024u;

// Samples of the tile whose footprints are shared, by their threads.
var<workgroup> shared_count: atomic<u32>;
var<workgroup> shared_samples: array<u32, 256>;

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

// A sample of the workgroup's tile in the picture.
struct Seen {
    // Where it lies; not seen where its reciprocal is 0.
    projected: Projected,
    footprint: Footprint,
    // Columns and rows that the footprint may cover, as `edges_around` gives them, and how many pixels they are.
    edges: vec4<i32>,
    pixels: u32,
    has_fringe: bool,
    // How far the footprint reaches with its fringe, in source pixels: to the left, right, up and down.
    reach: vec4<f32>,
}

// There is no fringe toward samples of the same tile, whose own footprints are there.
fn reach_of(at: vec2<u32>) -> vec4<f32> {
    let place = vec2<i32>(at);
    let beside = vec4<f32>(
        neighbor(place.x - 1, place.y),
        neighbor(place.x + 1, place.y),
        neighbor(place.x, place.y - 1),
        neighbor(place.x, place.y + 1),
    );
    return select(vec4<f32>(FRINGE), vec4<f32>(CORE_REACH), beside >= vec4<f32>(0.0));
}

// The pixels of a footprint with its fringe, as `edges_around` gives them.
fn edges_of_fringe(seen: Seen) -> vec4<i32> {
    let found = seen.footprint;
    let across = vec4<f32>(found.jacobian.xz * -seen.reach.x, found.jacobian.xz * seen.reach.y);
    let down = vec4<f32>(found.jacobian.yw * -seen.reach.z, found.jacobian.yw * seen.reach.w);
    let before = min(across.xy, across.zw) + min(down.xy, down.zw);
    let after = max(across.xy, across.zw) + max(down.xy, down.zw);
    let pixel = seen.projected.pixel;
    return edges_between(
        pixel + min(max(before, vec2<f32>(-found.largest)), vec2<f32>(-0.5)),
        pixel + max(min(after, vec2<f32>(found.largest)), vec2<f32>(0.5)),
    );
}

// The sample at `at` in the tile; called after `lay_out`.
fn see(projector: Projector, corner: vec2<f32>, at: vec2<u32>) -> Seen {
    var seen: Seen;
    let w = tile_inverse_depth[at.y * TILE + at.x];
    let projected = project(projector, corner.x, corner.y + f32(at.y), f32(at.x), w);
    if w >= 0.0 && is_seen(projected) {
        seen.projected = projected;
        if stage.kernel == KERNEL_SURFEL || stage.kernel == KERNEL_GATHER {
            seen.footprint = footprint(projector, projected, w, slopes(at, projector.per_footprint));
            let half_size = max(seen.footprint.half_size, vec2<f32>(0.5));
            seen.edges = edges_around(projected.pixel, half_size);
            let low = ceil(projected.pixel - half_size - 0.5);
            let high = floor(projected.pixel + half_size - 0.5);
            let is_large = any(high > low + 1.0) && seen.footprint.largest >= MAX_STRETCH * MAGNIFIED;
            // Edge on, nothing is known of the surface beside its sample.
            let is_known = any(seen.footprint.inverse != vec4<f32>(0.0));
            seen.has_fringe = stage.kernel == KERNEL_GATHER && stage.pruned != 0u && is_known && is_large;
            if seen.has_fringe {
                seen.reach = reach_of(at);
                seen.edges = edges_of_fringe(seen);
            }
            let size = max(seen.edges.yw - seen.edges.xz + 1, vec2<i32>(0));
            seen.pixels = u32(size.x) * u32(size.y);
        }
    }
    return seen;
}

// Raises the pixels of a footprint in every `step`th column and row, from `first` on. The fringe of magnified samples fills pixels
// that are in no footprint.
fn raise_footprint(seen: Seen, slot: u32, first: vec2<u32>, step: i32) {
    let found = seen.footprint;
    for (var y = seen.edges.z + i32(first.y); y <= seen.edges.w; y += step) {
        for (var x = seen.edges.x + i32(first.x); x <= seen.edges.y; x += step) {
            let off = vec2<f32>(f32(x), f32(y)) + 0.5 - seen.projected.pixel;
            let across = found.inverse.x * off.x + found.inverse.y * off.y;
            let down = found.inverse.z * off.x + found.inverse.w * off.y;
            let covered = max(abs(across), abs(down)) <= CORE_REACH || max(abs(off.x), abs(off.y)) <= 0.5;
            let on_fringe = seen.has_fringe
                && across >= -seen.reach.x && across <= seen.reach.y
                && down >= -seen.reach.z && down <= seen.reach.w;
            if covered || on_fringe {
                let most = found.deviation * select(FRINGE / CORE_REACH, 1.0, covered);
                let deviation = clamp(found.slope.x * off.x + found.slope.y * off.y, -most, most);
                let depth = max(found.inverse_depth + deviation, 0.0);
                raise(u32(y) * stage.width + u32(x), nearness(depth, select(0u, CORE, covered)), slot);
            }
        }
    }
}

@compute @workgroup_size(16, 16)
fn surface(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let nth = group.y * GROUPS_ACROSS + group.x;
    if nth >= stage.tile_count {
        return;
    }
    let number = stage.first_tile + nth;
    let piece = pieces[piece_of(number)];
    if thread == 0u {
        atomicStore(&shared_count, 0u);
    }
    let pixel = lay_out(piece, number, local.xy);
    let projector = projectors[piece.camera];
    let seen = see(projector, pixel.corner, local.xy);
    let slot = number << 8u | thread;
    if seen.pixels > SHARED_FROM {
        shared_samples[atomicAdd(&shared_count, 1u)] = thread;
    } else if seen.projected.reciprocal > 0.0 {
        switch stage.kernel {
            case KERNEL_POINT: { raise_point(seen.projected, pixel.inverse_depth, slot); }
            case KERNEL_BLOCK: { raise_block(seen.projected, pixel.inverse_depth, slot); }
            default: { raise_footprint(seen, slot, vec2<u32>(0u), 1); }
        }
    }
    workgroupBarrier();
    let count = atomicLoad(&shared_count);
    for (var nth = 0u; nth < count; nth++) {
        let sample = shared_samples[nth];
        let at = vec2<u32>(sample & 15u, sample >> 4u);
        raise_footprint(see(projector, pixel.corner, at), number << 8u | sample, local.xy, 16);
    }
}
