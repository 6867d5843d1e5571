// The silhouette stage: the surfaces of pixels at steps in depth, by the votes of all cameras.
// Twins: src/engine/render/gather/silhouette.rs, src/engine/render/gather/visibility_votes.rs.
//
// One workgroup a block of 16×16 pixels of the z-buffer, one thread a pixel.

// See the twin.
const OWN_SHARE: vec2<f32> = vec2<f32>(0.15, 1.2);
const SUBPIXEL_SHARE: vec2<f32> = vec2<f32>(0.1, 1.6);
const SUBPIXEL_CRACK_SHARE: vec2<f32> = vec2<f32>(-1.3, 4.1);
const LESS_BY_MANY: vec2<f32> = vec2<f32>(0.25, 0.4);
const MANY: f32 = 4.0;
const LEAST_SHARE: f32 = 1.0 / 256.0;
// The weight of samples that show nothing, beside agreeing ones: half of it counts for the surface and half against it.
const UNKNOWN_WEIGHT: f32 = 0.5;
// A surface is extrapolated beyond its edge if its inverse depth changes by at most this many tolerances a pixel.
const MAX_SLOPE: f32 = 8.0;
// Votes that sum to less than this share of the largest camera weight decide nothing.
const MIN_VOTES: f32 = 0.02;

// What one camera shows at a surface point, as shares of the 2×2 samples around it; `weight` is 0 outside its picture.
struct Vote {
    agree: f32,
    behind: f32,
    unknown: f32,
    weight: f32,
}

fn vote_of(camera: u32, at: vec2<f32>, w: f32) -> Vote {
    let reprojected = reproject(camera, at, w);
    var vote: Vote;
    if !reprojected.inside {
        return vote;
    }
    let quad = quad_at(camera, i32(reprojected.corner.x), i32(reprojected.corner.y));
    let limit = reprojected.expected * views[camera].tolerance;
    vote.weight = weight_of(camera, reprojected.distance_ratio, at, w);
    let shares = bilinear(reprojected.between);
    var depth = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let found = quad.depth[corner];
        if found >= 0.0 && abs(found - reprojected.expected) <= limit {
            vote.agree += shares[corner];
            depth += shares[corner] * found;
        } else if found >= 0.0 && found < reprojected.expected {
            vote.behind += shares[corner];
        } else {
            vote.unknown += shares[corner];
        }
    }
    if vote.agree > 0.0 {
        let projector = projectors[camera];
        let pixel = reprojected.corner + reprojected.between;
        let seen = ray(projector, pixel.x, pixel.y) + projector.origin * (depth / vote.agree);
        let off = abs(seen.xy / seen.z - at - 0.5);
        let displaced = vote.agree * min(max(off.x, off.y), 1.0);
        vote.agree -= displaced;
        vote.behind += displaced;
    }
    return vote;
}

fn raw_key_at(pixel: vec2<i32>) -> vec2<u32> {
    let reprojected = pixel + RING;
    return patch_keys[reprojected.y * SIDE + reprojected.x];
}

// A key of a core sample; 0, as for a hole, if it is of a fringe.
fn key_at(pixel: vec2<i32>, step: vec2<i32>) -> vec2<u32> {
    let key = raw_key_at(pixel + step);
    return select(vec2<u32>(0u), key, (key.y & CORE) != 0u);
}

// The share of the pixel that the votes give to the surface at inverse depth `w`; negative if there are too few votes.
fn share_of(at: vec2<f32>, w: f32, is_crack: bool) -> f32 {
    var agree = 0.0;
    var total = 0.0;
    var max_weight = 0.0;
    for (var nth = 0u; nth < camera_count; nth++) {
        let vote = vote_of(camera_list[nth], at, w);
        if vote.weight > 0.0 {
            let unknown = select(0.0, UNKNOWN_WEIGHT * vote.unknown, vote.agree > 0.0);
            agree += vote.weight * (vote.agree + 0.5 * unknown);
            total += vote.weight * (vote.agree + vote.behind + unknown);
            max_weight = max(max_weight, vote.weight);
        }
    }
    if total > MIN_VOTES * max_weight {
        let many = clamp((total / max_weight - 1.0) / (MANY - 1.0), 0.0, 1.0);
        let of_rim = vec2<f32>(SUBPIXEL_SHARE.x - LESS_BY_MANY.y * many, SUBPIXEL_SHARE.y);
        let of_subpixel = select(of_rim, SUBPIXEL_CRACK_SHARE, is_crack);
        let of_pixel = vec2<f32>(OWN_SHARE.x - LESS_BY_MANY.x * many, OWN_SHARE.y);
        let by = select(of_pixel, of_subpixel, stage.subpixels == 2u);
        let share = by.x + by.y * agree / total;
        return select(select(share, 1.0, share > 1.0 - LEAST_SHARE), 0.0, share < LEAST_SHARE);
    }
    return -1.0;
}

// Whether there is more than one surface, or none, in the 3×3 pixels around a pixel of the block.
fn is_edge(pixel: vec2<i32>) -> bool {
    var far = inverse_depth_of(key_at(pixel, vec2<i32>(0)).y);
    var near = far;
    for (var i = 0; i < 9; i++) {
        let w = inverse_depth_of(key_at(pixel, vec2<i32>(i % 3 - 1, i / 3 - 1)).y);
        far = min(far, w);
        near = max(near, w);
    }
    return far < near * stage.surface_ratio;
}

// Inverse depth at a pixel of the surface that the neighbor in direction `step` shows, extrapolated from the pixel beyond it.
fn extrapolated(neighbor: vec2<u32>, pixel: vec2<i32>, step: vec2<i32>) -> f32 {
    let w = inverse_depth_of(neighbor.y);
    let beyond = key_at(pixel, 2 * step);
    let growth = w - inverse_depth_of(beyond.y);
    let largest = MAX_SLOPE * (1.0 - stage.surface_ratio) * w;
    return select(w, max(w + growth, 0.0), beyond.y != 0u && abs(growth) <= largest);
}

// The farthest surface behind `own_w` that a neighbor shows, extrapolated to the pixel.
struct Behind {
    // Whether there is one; `key` is 0 if the only other neighbors are holes.
    found: bool,
    key: vec2<u32>,
}

fn farther(own_w: f32, pixel: vec2<i32>) -> Behind {
    var steps = array<vec2<i32>, 8>(
        vec2<i32>(-1, 0), vec2<i32>(1, 0), vec2<i32>(0, -1), vec2<i32>(0, 1),
        vec2<i32>(-1, -1), vec2<i32>(1, -1), vec2<i32>(-1, 1), vec2<i32>(1, 1),
    );
    let limit = own_w * stage.surface_ratio;
    var behind: Behind;
    var farthest = limit;
    for (var i = 0u; i < 8u; i++) {
        let neighbor = key_at(pixel, steps[i]);
        if neighbor.y == 0u {
            behind.found = true;
        } else if inverse_depth_of(neighbor.y) < limit {
            let w = extrapolated(neighbor, pixel, steps[i]);
            if w < farthest {
                farthest = w;
                behind.found = true;
                behind.key = vec2<u32>(neighbor.x, nearness(w, CORE | TRUSTED));
            }
        }
    }
    return behind;
}

// The nearest surface in front of `own_w` that two opposite neighbors show; 0 if there is none. Cracks are as wide as a pixel of
// the picture: where that has two sub-pixels, one of the neighbors may lie two steps away.
fn crack(own_w: f32, pixel: vec2<i32>) -> vec2<u32> {
    var steps =
        array<vec2<i32>, 4>(vec2<i32>(1, 0), vec2<i32>(0, 1), vec2<i32>(1, 1), vec2<i32>(1, -1));
    var nearest = -1.0;
    var found = vec2<u32>(0u);
    let widths = select(1u, 3u, stage.subpixels == 2u);
    for (var i = 0u; i < 4u * widths; i++) {
        let step = steps[i % 4u];
        let a = key_at(pixel, step * select(1, 2, i / 4u == 2u));
        let b = key_at(pixel, -step * select(1, 2, i / 4u == 1u));
        let wa = inverse_depth_of(a.y);
        let wb = inverse_depth_of(b.y);
        let mean = 0.5 * (wa + wb);
        let alike = a.y != 0u && b.y != 0u && min(wa, wb) >= max(wa, wb) * stage.surface_ratio;
        if alike && own_w < mean * stage.surface_ratio && mean > nearest {
            nearest = mean;
            found = vec2<u32>(a.x, nearness(mean, CORE | TRUSTED));
        }
    }
    return found;
}

// The surfaces of a pixel of the block, which lies at `at` in the picture; zeros for a hole.
fn decide(pixel: vec2<i32>, at: vec2<f32>) -> PixelSurfaces {
    let nothing = vec2<u32>(0u);
    let own = key_at(pixel, vec2<i32>(0));
    let own_w = inverse_depth_of(own.y);
    let only_own = PixelSurfaces(own, nothing, 1.0);
    if !is_edge(pixel) {
        return only_own;
    }
    // The surface that the cameras vote on, and what the pixel shows without it.
    var near = crack(own_w, pixel);
    var far = own;
    var is_crack = near.y != 0u;
    if !is_crack && own.y == 0u {
        // A fringe is voted on like a crack.
        near = raw_key_at(pixel);
        if near.y == 0u {
            return only_own;
        }
        near.y |= CORE;
        is_crack = true;
    }
    if !is_crack {
        let behind = farther(own_w, pixel);
        if !behind.found {
            return only_own;
        }
        near = own;
        far = behind.key;
    }
    var share = share_of(at, inverse_depth_of(near.y), is_crack);
    if share < 0.0 {
        if !is_crack {
            return only_own;
        }
        share = 1.0;
    }
    // Without the votes' support there is no crack to close but a real gap.
    if is_crack && share < 0.5 && own.y != 0u {
        return only_own;
    }
    // Of a whole pixel beside a hole no share is kept.
    if far.y == 0u && stage.subpixels == 1u {
        share = select(1.0, 0.0, share < 0.5);
    }
    return PixelSurfaces(select(near, nothing, far.y == 0u && share <= 0.0), far, share);
}

@compute @workgroup_size(16, 16)
fn silhouette(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let pixel = group.xy * TILE + local.xy;
    // Pixels of the background among its own samples; then those near a visible foreground, among all.
    for (var layer = 0u; layer < 2u; layer++) {
        let both = layer == 1u;
        if both && workgroupUniformLoad(&has_foreground) == 0u {
            break;
        }
        load_patch(group.xy, thread, both);
        if is_painted(pixel, local.xy, both) {
            let surfaces = decide(vec2<i32>(local.xy), vec2<f32>(pixel));
            write_surfaces(pixel, surfaces);
        }
    }
}
