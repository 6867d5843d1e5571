// The surface stage: which sample is nearest in each pixel. Twin: src/engine/render/splat/surface.rs.
//
// One workgroup a tile of samples, one thread a sample. Where the CPU works in blocks of sixteen and four corners, this is a plain
// loop over the pixels of a footprint; the maximum makes the order irrelevant. All threads of a workgroup share very large
// footprints.

// Footprints of more pixels are shared: the other threads would wait for one, and some adapters end loops of 65,536 steps.
const SHARED_FROM: u32 = 1024u;

// Samples of the tile whose footprints are shared, by their threads.
var<workgroup> shared_count: atomic<u32>;
var<workgroup> shared_samples: array<u32, 256>;

// A sample belongs to the core of a pixel that gets at least this share of it by bilinear weights, and else to its fringe.
const CORE_SHARE: f32 = 0.06;

fn raise_point(projected: Projected, w: f32, slot: u32, trust: u32) {
    let place = floor(projected.pixel);
    if all(place >= vec2<f32>(0.0)) && place.x < f32(stage.width) && place.y < f32(stage.height) {
        raise(u32(place.y) * stage.width + u32(place.x), nearness(w * projected.reciprocal, CORE | trust), slot);
    }
}

fn raise_block(projected: Projected, w: f32, slot: u32, trust: u32) {
    let corner = floor(projected.pixel - 0.5);
    let share = projected.pixel - 0.5 - corner;
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(f32(i & 1u), f32(i >> 1u));
        let place = corner + step;
        if all(place >= vec2<f32>(0.0)) && place.x < f32(stage.width) && place.y < f32(stage.height) {
            let shares = select(1.0 - share, share, step > vec2<f32>(0.5));
            let tier = select(0u, CORE, shares.x * shares.y >= CORE_SHARE);
            raise(u32(place.y) * stage.width + u32(place.x), nearness(w * projected.reciprocal, tier | trust), slot);
        }
    }
}

// A sample of the workgroup's tile in the picture.
struct ProjectedSample {
    // Where it lies; not visible if its reciprocal is 0.
    projected: Projected,
    footprint: Footprint,
    // Columns and rows that the footprint may cover, as `edges_around` gives them, and how many pixels they are.
    edges: vec4<i32>,
    pixels: u32,
    has_fringe: bool,
    // How far the footprint reaches with its fringe, in source pixels: to the left, right, up and down.
    reach: vec4<f32>,
}

// Toward samples of the same tile, which have footprints of their own, there is no fringe.
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
fn edges_of_fringe(sample: ProjectedSample) -> vec4<i32> {
    let found = sample.footprint;
    let across = vec4<f32>(found.jacobian.xz * -sample.reach.x, found.jacobian.xz * sample.reach.y);
    let down = vec4<f32>(found.jacobian.yw * -sample.reach.z, found.jacobian.yw * sample.reach.w);
    let before = min(across.xy, across.zw) + min(down.xy, down.zw);
    let after = max(across.xy, across.zw) + max(down.xy, down.zw);
    let pixel = sample.projected.pixel;
    return edges_between(
        pixel + min(max(before, vec2<f32>(-found.largest)), vec2<f32>(-0.5)),
        pixel + max(min(after, vec2<f32>(found.largest)), vec2<f32>(0.5)),
    );
}

// The sample at `at` in the tile; called after `lay_out`.
fn project_sample(projector: Projector, corner: vec2<f32>, at: vec2<u32>) -> ProjectedSample {
    var sample: ProjectedSample;
    let w = tile_inverse_depth[at.y * TILE + at.x];
    let projected = project(projector, corner.x, corner.y + f32(at.y), f32(at.x), w);
    if w >= 0.0 && is_seen(projected) {
        sample.projected = projected;
        if stage.kernel == KERNEL_SURFEL || stage.kernel == KERNEL_GATHER {
            sample.footprint = footprint(projector, projected, w, slopes(at, projector.per_footprint));
            let half_size = max(sample.footprint.half_size, vec2<f32>(0.5));
            sample.edges = edges_around(projected.pixel, half_size);
            let low = ceil(projected.pixel - half_size - 0.5);
            let high = floor(projected.pixel + half_size - 0.5);
            let is_large = any(high > low + 2.0) && sample.footprint.largest >= MAX_STRETCH * MAGNIFIED;
            // Edge on, the surface beside the sample is unknown.
            let is_known = any(sample.footprint.inverse != vec4<f32>(0.0));
            sample.has_fringe = stage.kernel == KERNEL_GATHER && stage.pruned != 0u && is_known && is_large;
            if sample.has_fringe {
                sample.reach = reach_of(at);
                sample.edges = edges_of_fringe(sample);
            }
            let size = max(sample.edges.yw - sample.edges.xz + 1, vec2<i32>(0));
            sample.pixels = u32(size.x) * u32(size.y);
        }
    }
    return sample;
}

// Raises the pixels of a footprint in every `step`th column and row, from `first` on. The fringe of magnified samples fills pixels
// that are in no footprint.
fn raise_footprint(sample: ProjectedSample, slot: u32, trust: u32, first: vec2<u32>, step: i32) {
    let found = sample.footprint;
    for (var y = sample.edges.z + i32(first.y); y <= sample.edges.w; y += step) {
        for (var x = sample.edges.x + i32(first.x); x <= sample.edges.y; x += step) {
            let off = vec2<f32>(f32(x), f32(y)) + 0.5 - sample.projected.pixel;
            let across = found.inverse.x * off.x + found.inverse.y * off.y;
            let down = found.inverse.z * off.x + found.inverse.w * off.y;
            let covered = max(abs(across), abs(down)) <= CORE_REACH || max(abs(off.x), abs(off.y)) <= 0.5;
            let on_fringe = sample.has_fringe
                && across >= -sample.reach.x && across <= sample.reach.y
                && down >= -sample.reach.z && down <= sample.reach.w;
            if covered || on_fringe {
                let most = found.deviation * select(FRINGE / CORE_REACH, 1.0, covered);
                let deviation = clamp(found.slope.x * off.x + found.slope.y * off.y, -most, most);
                let depth = max(found.inverse_depth + deviation, 0.0);
                raise(u32(y) * stage.width + u32(x), nearness(depth, select(0u, CORE, covered) | trust), slot);
            }
        }
    }
}

// TRUSTED, or 0 for a doubtful sample.
fn trust_of(piece: Piece, number: u32, at: vec2<u32>) -> u32 {
    return select(TRUSTED, 0u, is_doubtful(piece, number, at));
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
    let sample = project_sample(projector, pixel.corner, local.xy);
    let slot = number << 8u | thread;
    let trust = trust_of(piece, number, local.xy);
    if sample.pixels > SHARED_FROM {
        shared_samples[atomicAdd(&shared_count, 1u)] = thread;
    } else if sample.projected.reciprocal > 0.0 {
        switch stage.kernel {
            case KERNEL_POINT: { raise_point(sample.projected, pixel.inverse_depth, slot, trust); }
            case KERNEL_BLOCK: { raise_block(sample.projected, pixel.inverse_depth, slot, trust); }
            default: { raise_footprint(sample, slot, trust, vec2<u32>(0u), 1); }
        }
    }
    workgroupBarrier();
    let count = atomicLoad(&shared_count);
    for (var nth = 0u; nth < count; nth++) {
        let sample = shared_samples[nth];
        let at = vec2<u32>(sample & 15u, sample >> 4u);
        let shared_trust = trust_of(piece, number, at);
        raise_footprint(project_sample(projector, pixel.corner, at), number << 8u | sample, shared_trust, local.xy, 16);
    }
}
