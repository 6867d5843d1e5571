// The silhouette stage: what stands in pixels at steps in depth, by the votes of all cameras.
// Twins: src/render/silhouette.rs, `Gather::vote` in src/render/votes.rs.
//
// One workgroup a block of 16×16 pixels, one thread a pixel.

const LEAST: f32 = 0.15;
const SLOPE: f32 = 1.2;
// Samples beside agreeing ones that say nothing count this much, half for the surface and half against it.
const SILENCE: f32 = 0.5;
// A surface is carried on beyond its edge as long as it recedes by no more than this many tolerances a pixel.
const STEEPEST: f32 = 8.0;
// Votes that weigh less than this share of what the camera that counts most could say decide nothing.
const FEWEST_VOTES: f32 = 0.02;

// How one camera sees a surface point, as shares of the 2×2 samples around it; `weight` is 0 where it does not.
struct Sight {
    agree: f32,
    through: f32,
    silent: f32,
    weight: f32,
}

fn sight_of(camera: u32, at: vec2<f32>, w: f32) -> Sight {
    let place = place_in(camera, at, w);
    var sight: Sight;
    if !place.inside {
        return sight;
    }
    let quad = quad_at(camera, i32(place.corner.x), i32(place.corner.y));
    let limit = place.expected * views[camera].tolerance;
    sight.weight = weight_of(camera, place.reciprocal, at, w);
    let shares = bilinear(place.between);
    var depth = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let found = quad.depth[corner];
        if found >= 0.0 && abs(found - place.expected) <= limit {
            sight.agree += shares[corner];
            depth += shares[corner] * found;
        } else if found >= 0.0 && found < place.expected {
            sight.through += shares[corner];
        } else {
            sight.silent += shares[corner];
        }
    }
    if sight.agree > 0.0 {
        let projector = projectors[camera];
        let pixel = place.corner + place.between;
        let seen = ray(projector, pixel.x, pixel.y) + projector.origin * (depth / sight.agree);
        let off = abs(seen.xy / seen.z - at - 0.5);
        let doubt = sight.agree * min(max(off.x, off.y), 1.0);
        sight.agree -= doubt;
        sight.through += doubt;
    }
    return sight;
}

fn raw_key_at(pixel: vec2<i32>) -> vec2<u32> {
    let place = pixel + RING;
    return patch_keys[place.y * SIDE + place.x];
}

// A key, unless it is of a fringe: 0 then, as of a hole.
fn key_at(pixel: vec2<i32>, step: vec2<i32>) -> vec2<u32> {
    let key = raw_key_at(pixel + step);
    return select(vec2<u32>(0u), key, (key.y & CORE) != 0u);
}

// The votes for the surface at inverse depth `w`; negative where too few have one.
fn share_of(at: vec2<f32>, w: f32) -> f32 {
    var agree = 0.0;
    var total = 0.0;
    var most = 0.0;
    for (var nth = 0u; nth < camera_count; nth++) {
        let sight = sight_of(camera_list[nth], at, w);
        if sight.weight > 0.0 {
            let silent = select(0.0, SILENCE * sight.silent, sight.agree > 0.0);
            agree += sight.weight * (sight.agree + 0.5 * silent);
            total += sight.weight * (sight.agree + sight.through + silent);
            most = max(most, sight.weight);
        }
    }
    if total > FEWEST_VOTES * most {
        return clamp(LEAST + SLOPE * agree / total, 0.0, 1.0);
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

// Inverse depth at a pixel of the surface that the neighbor in direction `step` shows, by the one behind that.
fn carried_on(neighbor: vec2<u32>, pixel: vec2<i32>, step: vec2<i32>) -> f32 {
    let w = inverse_depth_of(neighbor.y);
    let beyond = key_at(pixel, 2 * step);
    let growth = w - inverse_depth_of(beyond.y);
    let steepest = STEEPEST * (1.0 - stage.surface_ratio) * w;
    return select(w, max(w + growth, 0.0), beyond.y != 0u && abs(growth) <= steepest);
}

// The surface behind `own_w` that a neighbor shows, carried on to the pixel.
struct Behind {
    // Whether there is one; `key` is 0 where only holes are beside the surface.
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
            let w = carried_on(neighbor, pixel, steps[i]);
            if w < farthest {
                farthest = w;
                behind.found = true;
                behind.key = vec2<u32>(neighbor.x, nearness(w, CORE));
            }
        }
    }
    return behind;
}

// The surface before `own_w` that two opposite neighbors show alike; 0 where there is none.
fn crack(own_w: f32, pixel: vec2<i32>) -> vec2<u32> {
    var steps =
        array<vec2<i32>, 4>(vec2<i32>(1, 0), vec2<i32>(0, 1), vec2<i32>(1, 1), vec2<i32>(1, -1));
    var nearest = -1.0;
    var found = vec2<u32>(0u);
    for (var i = 0u; i < 4u; i++) {
        let a = key_at(pixel, steps[i]);
        let b = key_at(pixel, -steps[i]);
        let wa = inverse_depth_of(a.y);
        let wb = inverse_depth_of(b.y);
        let mean = 0.5 * (wa + wb);
        let alike = a.y != 0u && b.y != 0u && min(wa, wb) >= max(wa, wb) * stage.surface_ratio;
        if alike && own_w < mean * stage.surface_ratio && mean > nearest {
            nearest = mean;
            found = vec2<u32>(a.x, nearness(mean, CORE));
        }
    }
    return found;
}

// What stands in a pixel of the block, which lies at `at` in the picture; zeros where nothing does.
fn decide(pixel: vec2<i32>, at: vec2<f32>) -> Standing {
    let nothing = vec2<u32>(0u);
    let own = key_at(pixel, vec2<i32>(0));
    let own_w = inverse_depth_of(own.y);
    let only_own = Standing(own, nothing, 1.0);
    if !is_edge(pixel) {
        return only_own;
    }
    // The surface that the cameras vote for, and what stands there without it.
    var near = crack(own_w, pixel);
    var far = own;
    var is_crack = near.y != 0u;
    if !is_crack && own.y == 0u {
        // What a fringe claims is put to the vote like a crack.
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
    var share = share_of(at, inverse_depth_of(near.y));
    if share < 0.0 {
        if !is_crack {
            return only_own;
        }
        share = 1.0;
    }
    // What the votes do not carry is no crack: the gap is there.
    if is_crack && share < 0.5 {
        return only_own;
    }
    if far.y == 0u {
        return Standing(select(near, nothing, share < 0.5), nothing, 1.0);
    }
    return Standing(near, far, share);
}

@compute @workgroup_size(16, 16)
fn silhouette(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let pixel = group.xy * TILE + local.xy;
    // Pixels of the background among its own samples; then those beside which a foreground is seen, among all.
    for (var layer = 0u; layer < 2u; layer++) {
        let both = layer == 1u;
        if both && workgroupUniformLoad(&has_foreground) == 0u {
            break;
        }
        load_patch(group.xy, thread, both);
        if is_painted(pixel, local.xy, both) {
            let standing = decide(vec2<i32>(local.xy), vec2<f32>(pixel));
            put_standing(pixel.y * stage.width + pixel.x, standing);
        }
    }
}
