// The z-buffer of a block of pixels and a ring around it, and the cameras whose samples are seen there.
// Twins: `ResolveInput` in src/engine/render/resolve/layers.rs, `FrameSamples::cameras_of`.

@group(1) @binding(0) var<storage, read> background_keys: array<u32>;
@group(1) @binding(1) var<storage, read> foreground_keys: array<u32>;
@group(1) @binding(2) var<storage, read_write> picture: array<u32>;

// Pixels around a block that decisions in it read, and the side of a block with its ring.
const RING: i32 = 2;
const SIDE: i32 = 20;
const SIDE_SQUARED: u32 = 400u;

// Keys of the block and its ring; beyond the picture its outermost pixels repeat.
var<workgroup> patch_keys: array<vec2<u32>, SIDE_SQUARED>;

// The cameras whose samples are in the patch: a bit each, their ascending list, and their list by weight for the surface in the
// middle of the block, largest first. Weights are bits of floats; `find_near` uses the memory of both lists' makings again.
const CAMERA_WORDS: u32 = 32u;
var<workgroup> camera_bits: array<atomic<u32>, CAMERA_WORDS>;
var<workgroup> camera_set: array<u32, 1024>;
var<workgroup> camera_weight: array<u32, 1024>;
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
        camera_set[count] = 32u * nth + firstTrailingBit(left);
        count += 1u;
        left &= left - 1u;
    }
    if nth + 1u == CAMERA_WORDS {
        camera_count = count;
    }
}

// An inverse depth that grows by this share over two pixels, or more, is a step and no slope.
const MAX_GROWTH: f32 = 0.25;

// The inverse depth of a core sample of the patch; negative where there is none.
fn core_depth(at: vec2<u32>) -> f32 {
    let upper = patch_keys[at.y * u32(SIDE) + at.x].y;
    return inverse_depth_of(select(0u, upper, (upper & CORE) != 0u));
}

// The sum of the inverse depths of four pixels.
fn sum_of_four(at: vec2<u32>) -> f32 {
    let above = core_depth(at) + core_depth(at + vec2<u32>(1u, 0u));
    return above + (core_depth(at + vec2<u32>(0u, 1u)) + core_depth(at + vec2<u32>(1u, 1u)));
}

// Growth over one pixel, from sums of four over two pixels before and after.
fn growth(before: f32, here: f32, after: f32) -> f32 {
    let back = here - before;
    let on = after - here;
    let least = select(on, back, abs(back) < abs(on));
    return select(0.0, 0.125 * least, back * on > 0.0 && abs(least) < MAX_GROWTH * here);
}

// Growth of the inverse depth by column and by row around the middle of the four pixels from a pixel of the block on. Twin:
// `Patch::slope` in src/engine/render/gather/silhouette.rs.
fn slope_around(pixel: vec2<u32>) -> vec2<f32> {
    let at = min(pixel, vec2<u32>(TILE - 2u)) + u32(RING);
    let here = sum_of_four(at);
    let across = vec2<u32>(2u, 0u);
    let down = vec2<u32>(0u, 2u);
    return vec2<f32>(
        growth(sum_of_four(at - across), here, sum_of_four(at + across)),
        growth(sum_of_four(at - down), here, sum_of_four(at + down)),
    );
}

// Inverse depth of the surface in the middle of the patch.
fn middle_depth() -> f32 {
    return max(inverse_depth_of(patch_keys[SIDE_SQUARED / 2u + u32(SIDE) / 2u].y), 0.0);
}

// Depth in a camera of the surface in the middle of the block whose first pixel is `corner`, over that in the vantage.
fn middle_distance(camera: u32, corner: vec2<i32>) -> f32 {
    let at = vec2<f32>(corner) + f32(TILE / 2u);
    let projector = views[camera].source_from_target;
    return (ray(projector, at.x, at.y) + projector.origin * middle_depth()).z;
}

// Weighs a camera for the middle of the block whose first pixel is `corner`.
fn weigh_camera(nth: u32, corner: vec2<i32>) {
    let camera = camera_set[nth];
    let at = vec2<f32>(corner) + f32(TILE / 2u);
    let z = middle_distance(camera, corner);
    var weight = 0.0;
    if z > 0.0 {
        weight = weight_on_surface(camera, 1.0 / z, at, middle_depth(), slope_around(vec2<u32>(TILE / 2u)));
    }
    camera_weight[nth] = bitcast<u32>(weight);
}

// Puts a camera into the list behind all of larger weight, and those before it of the same weight.
fn rank_camera(nth: u32) {
    let weight = bitcast<f32>(camera_weight[nth]);
    var place = 0u;
    for (var other = 0u; other < camera_count; other++) {
        let of_other = bitcast<f32>(camera_weight[other]);
        let ahead = of_other > weight || (of_other == weight && other < nth);
        place += select(0u, 1u, ahead);
    }
    camera_list[place] = camera_set[nth];
}

// Where foreground samples are visible in the patch: a bit per column, for each row; and whether there are any.
var<workgroup> foreground_rows: array<atomic<u32>, SIDE>;
var<workgroup> has_foreground: u32;

// Whether a foreground sample is visible within RING pixels of a pixel of the block, or of another that shares its pixel of the
// picture; only there are samples of the foreground read.
fn is_near_foreground(pixel: vec2<u32>) -> bool {
    let first = pixel / stage.subpixels * stage.subpixels;
    let reach = 2u * u32(RING) + stage.subpixels;
    var near = 0u;
    for (var row = 0u; row < reach; row++) {
        near |= atomicLoad(&foreground_rows[first.y + row]);
    }
    return extractBits(near, first.x, reach) != 0u;
}

// Whether a pixel of the z-buffer, `local` in its block, is painted among the samples of both layers, or of the background alone.
fn is_painted(pixel: vec2<u32>, local: vec2<u32>, both: bool) -> bool {
    return pixel.x < stage.width && pixel.y < stage.height && is_near_foreground(local) == both;
}

// Loads one pixel of the patch around the block whose first pixel is `corner`: of the background, or of both layers.
fn load(corner: vec2<i32>, place: u32, both: bool) {
    let wanted = corner + vec2<i32>(i32(place) % SIDE, i32(place) / SIDE) - RING;
    let pixel = clamp(wanted, vec2<i32>(0), vec2<i32>(i32(stage.width), i32(stage.height)) - 1);
    let at = 2u * (u32(pixel.y) * stage.width + u32(pixel.x));
    let back = vec2<u32>(background_keys[at], background_keys[at + 1u]);
    let front = vec2<u32>(foreground_keys[at], foreground_keys[at + 1u]);
    let front_wins = front.y > back.y || (front.y == back.y && front.x > back.x);
    let is_same = inverse_depth_of(front.y) >= inverse_depth_of(back.y) * stage.surface_ratio;
    if front_wins || (front.y != 0u && is_same) {
        atomicOr(&foreground_rows[place / u32(SIDE)], 1u << (place % u32(SIDE)));
    }
    let key = select(back, front, front_wins && both);
    patch_keys[place] = key;
    if key.y != 0u {
        let camera = pieces[piece_of(~key.x >> 8u)].camera;
        atomicOr(&camera_bits[camera / 32u], 1u << (camera & 31u));
    }
}

// Loads the patch of a block, of the background or of both layers, and sets what `quad_at` reads; called by all threads of
// a workgroup of 16×16.
fn load_patch(block: vec2<u32>, thread: u32, both: bool) {
    workgroupBarrier();
    if thread < u32(SIDE) {
        atomicStore(&foreground_rows[thread], 0u);
    }
    if thread < CAMERA_WORDS {
        atomicStore(&camera_bits[thread], 0u);
    }
    workgroupBarrier();
    let corner = vec2<i32>(block * TILE);
    load(corner, thread, both);
    if thread + 256u < SIDE_SQUARED {
        load(corner, thread + 256u, both);
    }
    workgroupBarrier();
    if thread == 0u {
        has_foreground = 0u;
        for (var row = 0u; row < u32(SIDE); row++) {
            has_foreground |= atomicLoad(&foreground_rows[row]);
        }
    }
    if thread < CAMERA_WORDS {
        list_cameras(thread);
    }
    workgroupBarrier();
    for (var nth = thread; nth < camera_count; nth += 256u) {
        weigh_camera(nth, corner);
    }
    workgroupBarrier();
    for (var nth = thread; nth < camera_count; nth += 256u) {
        rank_camera(nth);
    }
    workgroupBarrier();
    visible_tiles = select(stage.background_tiles, stage.all_tiles, both);
}

// The surfaces of a pixel: the keys of a nearer and a farther one, and the share of the nearer; what a farther one of key 0 takes is a
// hole.
struct PixelSurfaces {
    near: vec2<u32>,
    far: vec2<u32>,
    share: f32,
}

// Words of the surfaces of a pixel of the z-buffer.
const SURFACE_WORDS: u32 = 5u;

// Where they begin: behind the words of the picture.
fn surfaces_at(pixel: vec2<u32>) -> u32 {
    return picture_words() * picture_pixels() + SURFACE_WORDS * (pixel.y * stage.width + pixel.x);
}

fn write_surfaces(pixel: vec2<u32>, surfaces: PixelSurfaces) {
    let at = surfaces_at(pixel);
    picture[at] = surfaces.near.x;
    picture[at + 1u] = surfaces.near.y;
    picture[at + 2u] = surfaces.far.x;
    picture[at + 3u] = surfaces.far.y;
    picture[at + 4u] = bitcast<u32>(surfaces.share);
}

fn read_surfaces(pixel: vec2<u32>) -> PixelSurfaces {
    let at = surfaces_at(pixel);
    let near = vec2<u32>(picture[at], picture[at + 1u]);
    let far = vec2<u32>(picture[at + 2u], picture[at + 3u]);
    return PixelSurfaces(near, far, bitcast<f32>(picture[at + 4u]));
}
