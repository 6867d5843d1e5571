// The gather stage: from keys to a picture, block by block, with colors looked up in the cameras.
// Twins: `Strip::gather` in src/render/resolve.rs, `Gather::color` in src/render/gather.rs.
//
// One workgroup a block of 16×16 pixels, one thread a pixel.

@group(1) @binding(0) var<storage, read> background_keys: array<u32>;
@group(1) @binding(1) var<storage, read> foreground_keys: array<u32>;
@group(1) @binding(2) var<storage, read_write> picture: array<u32>;

// Whether a foreground sample is seen in the block or beside it; only then are its samples looked at.
var<workgroup> has_foreground: atomic<u32>;

// Loads one pixel of the patch around the block whose first pixel is `corner`.
fn load(corner: vec2<i32>, place: u32) {
    let wanted = corner + vec2<i32>(i32(place) % SIDE, i32(place) / SIDE) - RING;
    let pixel = clamp(wanted, vec2<i32>(0), vec2<i32>(i32(stage.width), i32(stage.height)) - 1);
    let at = 2u * (u32(pixel.y) * stage.width + u32(pixel.x));
    let back = vec2<u32>(background_keys[at], background_keys[at + 1u]);
    let front = vec2<u32>(foreground_keys[at], foreground_keys[at + 1u]);
    if front.y != 0u && inverse_depth_of(front.y) >= inverse_depth_of(back.y) * stage.surface_ratio {
        atomicOr(&has_foreground, 1u);
    }
    let front_wins = front.y > back.y || (front.y == back.y && front.x > back.x);
    let key = select(back, front, front_wins);
    patch_keys[place] = key;
    if key.y != 0u {
        let camera = pieces[piece_of(~key.x >> 8u)].camera;
        atomicOr(&camera_bits[camera / 32u], 1u << (camera & 31u));
    }
}

// The color of the surface that `key` stands for in pixel `at`; the nearest sample's own where nothing can be interpolated.
fn surface_color(key: vec2<u32>, at: vec2<f32>) -> vec3<f32> {
    let w = inverse_depth_of(key.y);
    var sum = vec4<f32>(0.0);
    for (var nth = 0u; nth < camera_count; nth++) {
        sum += answer(camera_list[nth], at, w);
    }
    if sum.w < ENOUGH {
        let lack = (ENOUGH - sum.w) * OWN_SHARE + 1e-6;
        sum += vec4<f32>(color_of(~key.x), 1.0) * lack;
    }
    return sum.xyz / sum.w;
}

@compute @workgroup_size(16, 16)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if thread == 0u {
        atomicStore(&has_foreground, 0u);
    }
    if thread < CAMERA_WORDS {
        atomicStore(&camera_bits[thread], 0u);
    }
    workgroupBarrier();
    let corner = vec2<i32>(group.xy * TILE);
    load(corner, thread);
    if thread + 256u < SIDE_SQUARED {
        load(corner, thread + 256u);
    }
    workgroupBarrier();
    if thread < CAMERA_WORDS {
        list_cameras(thread);
    }
    workgroupBarrier();
    let pixel = group.xy * TILE + local.xy;
    if pixel.x >= stage.width || pixel.y >= stage.height {
        return;
    }
    visible_tiles = select(stage.lasting_tiles, stage.all_tiles, atomicLoad(&has_foreground) != 0u);
    let at = vec2<f32>(pixel);
    let standing = decide(vec2<i32>(local.xy), at);
    var color = vec3<f32>(0.0);
    // One loop for both surfaces, so that compilers that inline everything have half as much to inline.
    for (var side = 0u; side < 2u; side++) {
        let key = select(standing.near, standing.far, side == 1u);
        let share = select(standing.share, 1.0 - standing.share, side == 1u);
        if key.y != 0u {
            color += share * surface_color(key, at);
        }
    }
    let shows_far = standing.far.y != 0u && standing.share < 0.5;
    let key = select(standing.near, standing.far, shows_far);
    set_pixel(pixel.y * stage.width + pixel.x, key, color);
}
