// What stands in pixels at steps in depth, by the votes of all cameras. Twin: src/render/silhouette.rs.

const LEAST: f32 = 0.15;
const SLOPE: f32 = 1.2;
// Samples beside agreeing ones that say nothing count this much, half for the surface and half against it.
const SILENCE: f32 = 0.5;
// A surface is carried on beyond its edge as long as it recedes by no more than this many tolerances a pixel.
const STEEPEST: f32 = 8.0;
// Votes that weigh less than this decide nothing.
const FEWEST_VOTES: f32 = 0.02;

// Pixels around a block that decisions in it look at, and the side of a block with its ring.
const RING: i32 = 2;
const SIDE: i32 = 20;
const SIDE_SQUARED: u32 = 400u;

// The z-buffer of a block of pixels and the ring around it; beyond the picture its border goes on.
var<workgroup> patch_keys: array<vec2<u32>, SIDE_SQUARED>;

// The cameras whose samples are in the patch: a bit each, and from that a list, ascending.
const CAMERA_WORDS: u32 = 32u;
var<workgroup> camera_bits: array<atomic<u32>, CAMERA_WORDS>;
var<workgroup> camera_list: array<u32, 1024>;
var<workgroup> camera_count: u32;

// Lists the cameras of one word of bits; called for every word.
fn list_cameras(nth: u32) {
    var count = 0u;
    for (var before = 0u; before < nth; before++) {
        count += countOneBits(atomicLoad(&camera_bits[before]));
    }
    var left = atomicLoad(&camera_bits[nth]);
    while left != 0u {
        camera_list[count] = 32u * nth + firstTrailingBit(left);
        count += 1u;
        left &= left - 1u;
    }
    if nth + 1u == CAMERA_WORDS {
        camera_count = count;
    }
}

// What stands in a pixel: a nearer surface, a farther one, and the share of the nearer, which is 1 where there is no other.
struct Standing {
    near: vec2<u32>,
    far: vec2<u32>,
    share: f32,
}

fn key_at(pixel: vec2<i32>, step: vec2<i32>) -> vec2<u32> {
    let place = pixel + step + RING;
    return patch_keys[place.y * SIDE + place.x];
}

// The votes for the surface at inverse depth `w`; negative where too few have one.
fn share_of(at: vec2<f32>, w: f32) -> f32 {
    var agree = 0.0;
    var total = 0.0;
    for (var nth = 0u; nth < camera_count; nth++) {
        let sight = sight_of(camera_list[nth], at, w);
        if sight.weight > 0.0 {
            let silent = select(0.0, SILENCE * sight.silent, sight.agree > 0.0);
            agree += sight.weight * (sight.agree + 0.5 * silent);
            total += sight.weight * (sight.agree + sight.through + silent);
        }
    }
    if total > FEWEST_VOTES {
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
    let is_crack = near.y != 0u;
    if !is_crack {
        if own.y == 0u {
            return only_own;
        }
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
    if far.y == 0u {
        return Standing(select(near, nothing, share < 0.5), nothing, 1.0);
    }
    return Standing(near, far, share);
}
