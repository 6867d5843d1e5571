// The gather stage: the color of each surface of a pixel, looked up in the cameras.
// Twins: src/engine/render/gather/interpolate.rs, src/engine/render/gather/near_cameras.rs, src/engine/render/gather/subpixels.rs, `SurfacePoints::add_colors`, `GatherScratch::gather`.
//
// One workgroup a block of 16×16 pixels of the z-buffer, one thread a pixel of the picture.

// Where less than this share of a pixel is covered by interpolated samples, the nearest sample's own color is mixed in …
const MIN_COVERAGE: f32 = 0.25;
// … with this weight for each share below that.
const OWN_SHARE: f32 = 0.2;
// The weight of a camera of whose 2×2 samples some lie on another surface.
const BESIDE_EDGE: f32 = 0.3;
// Depths that differ by less than this part of the tolerance are taken as equal.
const EXACT: f32 = 0.005;
// A sub-pixel is at most this many samples wide.
const SUBPIXEL_WIDTH: f32 = 2.5;
// Most sub-pixels along each side of a pixel.
const MAX_SUBPIXELS: f32 = 4.0;
// A pixel shows samples from this share on that they cover.
const LEAST_SHOWN: f32 = 0.5;

// Where between the 2×2 samples the pixel's line of sight meets the surface that the camera itself saw, at `depth`.
fn corrected(camera: u32, reprojected: Reprojected, at: vec2<f32>, depth: f32) -> vec2<f32> {
    let back = projectors[camera];
    let pixel = reprojected.corner + reprojected.between;
    let seen = ray(back, pixel.x, pixel.y) + back.origin * depth;
    let there = views[camera].source_from_target;
    let point = ray(there, at.x, at.y) * seen.z + there.origin * depth;
    let found = point.xy * (1.0 / point.z) - 0.5 - reprojected.corner;
    let sound = seen.z > 0.0 && point.z > 0.0;
    return select(reprojected.between, clamp(found, vec2<f32>(0.0), vec2<f32>(1.0)), sound);
}

// A point of a surface: column and row in the z-buffer, inverse depth, and its growth by column and row, 0 where it is not known.
struct SurfacePoint {
    at: vec2<f32>,
    w: f32,
    slope: vec2<f32>,
}

// The color that one camera gives; zeros if it shows another surface.
struct ViewColor {
    // Color times weight, and weight.
    sum: vec4<f32>,
    // Share of the pixel that samples cover.
    coverage: f32,
}

fn interpolated(camera: u32, reprojected: Reprojected, point: SurfacePoint) -> ViewColor {
    let quad = quad_at(camera, i32(reprojected.corner.x), i32(reprojected.corner.y));
    let limit = reprojected.expected * views[camera].tolerance;
    var shares = bilinear(reprojected.between);
    var agrees: array<bool, 4>;
    var shown: array<f32, 4>;
    for (var corner = 0u; corner < 4u; corner++) {
        let found = quad.depth[corner];
        agrees[corner] = found >= 0.0 && abs(found - reprojected.expected) <= limit;
        shown[corner] = select(0.0, shares[corner], agrees[corner]);
    }
    var coverage = (shown[0] + shown[1]) + (shown[2] + shown[3]);
    if coverage < 1e-3 {
        return ViewColor();
    }
    let above = shown[0] * quad.depth[0] + shown[1] * quad.depth[1];
    let below = shown[2] * quad.depth[2] + shown[3] * quad.depth[3];
    let depth = (above + below) / coverage;
    // Where the camera agrees with the z-buffer to a small part of the tolerance, correcting moves nothing.
    if abs(depth - reprojected.expected) > EXACT * limit {
        shares = bilinear(corrected(camera, reprojected, point.at, depth));
    }
    var color = vec3<f32>(0.0);
    var beside = false;
    coverage = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        if agrees[corner] {
            color += shares[corner] * unpack_color(pieces[quad.piece[corner]], quad.index[corner]);
            coverage += shares[corner];
        } else if quad.depth[corner] >= 0.0 {
            beside = true;
        }
    }
    let weight = weight_on_surface(camera, reprojected.distance_ratio, point.at, point.w, point.slope);
    return ViewColor(vec4<f32>(color, coverage) * weight * select(1.0, BESIDE_EDGE, beside), coverage);
}

fn color_in(camera: u32, point: SurfacePoint) -> ViewColor {
    let reprojected = reproject(camera, point.at, point.w);
    var found: ViewColor;
    if !reprojected.inside {
        return found;
    }
    // Where the picture is coarser than the camera's, one look-up would alias fine detail. One sub-pixel is the pixel itself.
    let rate = rate_of(camera, reprojected.distance_ratio);
    let count = clamp(ceil(rate / SUBPIXEL_WIDTH), 1.0, MAX_SUBPIXELS);
    let per_subpixel = 1.0 / count;
    for (var nth = 0u; nth < u32(count * count); nth++) {
        let sub = vec2<f32>(f32(nth % u32(count)), f32(nth / u32(count)));
        let sub_at = point.at + ((sub + 0.5) * per_subpixel - 0.5) * f32(stage.subpixels);
        let sub_reprojected = reproject(camera, sub_at, point.w);
        if sub_reprojected.inside {
            let part = interpolated(camera, sub_reprojected, SurfacePoint(sub_at, point.w, point.slope));
            found.sum += part.sum;
            found.coverage += part.coverage;
        }
    }
    let share = per_subpixel * per_subpixel;
    return ViewColor(found.sum * share, found.coverage * share);
}

// Where a block shows samples of so few cameras, all are asked.
const FEW: u32 = 4u;

// Cameras that recorded so coarsely that their samples count farther away than the ring reaches: bits as `bit_of` gives them.
var<workgroup> coarse_cameras: atomic<u32>;

// The bit of a camera in masks, by its place in the list; the last bit stands for all from there on.
fn bit_of(place: u32) -> u32 {
    return 1u << min(place, 31u);
}

// Whether it is found which cameras are seen around each pixel.
fn finds_near() -> bool {
    return stage.pruned != 0u && camera_count > FEW;
}

// Finds the bit of the camera of each key of the patch; called by all threads after `load_patch`. In `camera_weight` are then the places
// of cameras, and in `camera_set` the bits.
fn find_near(block: vec2<u32>, thread: u32) {
    if thread == 0u {
        atomicStore(&coarse_cameras, 0u);
    }
    workgroupBarrier();
    for (var place = thread; place < camera_count; place += 256u) {
        let camera = camera_list[place];
        camera_weight[camera] = place;
        let z = middle_distance(camera, vec2<i32>(block * TILE));
        let is_fine = z > 0.0 && rate_of(camera, 1.0 / z) * 2.0 * f32(RING) >= f32(stage.subpixels);
        if !is_fine {
            atomicOr(&coarse_cameras, bit_of(place));
        }
    }
    workgroupBarrier();
    for (var nth = thread; nth < SIDE_SQUARED; nth += 256u) {
        let key = patch_keys[nth];
        camera_set[nth] = 0u;
        if key.y != 0u {
            camera_set[nth] = bit_of(camera_weight[pieces[piece_of(~key.x >> 8u)].camera]);
        }
    }
    workgroupBarrier();
}

// The cameras that can tell something of the pixel of the picture whose first sub-pixel is `local` in its block: those of which a sample
// is seen within the ring's breadth of it.
fn near_cameras(local: vec2<u32>) -> u32 {
    if !finds_near() {
        return 0xffffffffu;
    }
    let reach = 2u * u32(RING) + stage.subpixels;
    var near = atomicLoad(&coarse_cameras);
    for (var nth = 0u; nth < reach * reach; nth++) {
        near |= camera_set[(local.y + nth / reach) * u32(SIDE) + local.x + nth % reach];
    }
    return near;
}

// The color of the surface of `key` at a point, from the cameras `near` it, the best first; in a pruned set the camera of the nearest
// sample, which kept it, comes before them.
fn surface_color(key: vec2<u32>, point: SurfacePoint, near: u32) -> vec3<f32> {
    let pruned = stage.pruned != 0u;
    let sample_camera = pieces[piece_of(~key.x >> 8u)].camera;
    var sum = vec4<f32>(0.0);
    var coverage = 0.0;
    var camera = sample_camera;
    var is_wanted = pruned;
    var next = 0u;
    loop {
        if is_wanted {
            let found = color_in(camera, point);
            sum += found.sum;
            coverage += found.coverage;
        }
        if next == camera_count || coverage >= stage.full_coverage {
            break;
        }
        camera = camera_list[next];
        is_wanted = (!pruned || camera != sample_camera) && (near & bit_of(next)) != 0u;
        next += 1u;
    }
    if coverage < MIN_COVERAGE {
        let lack = select(1.0, (MIN_COVERAGE - coverage) * OWN_SHARE * sum.w / coverage, coverage > 0.0);
        sum += vec4<f32>(color_of(~key.x), 1.0) * lack;
    }
    return sum.xyz / sum.w;
}

// A surface that some sub-pixels of a pixel show. Sums over these, weighted by their shares.
struct SharedSurface {
    // Key of the sub-pixel that was found first.
    key: vec2<u32>,
    share: f32,
    at: vec2<f32>,
    w: f32,
}

// The surfaces of one pixel, a nearer and a farther one for each sub-pixel at most, and how many of the sub-pixels they cover.
const MOST_SURFACES: u32 = 8u;
struct PixelParts {
    surfaces: array<SharedSurface, MOST_SURFACES>,
    count: u32,
    shown: f32,
}

// The surfaces of the pixel of the picture whose first sub-pixel this is, joined where they are the same.
fn parts_of(first: vec2<u32>) -> PixelParts {
    var parts: PixelParts;
    for (var nth = 0u; nth < stage.subpixels * stage.subpixels; nth++) {
        let pixel = first + vec2<u32>(nth % stage.subpixels, nth / stage.subpixels);
        let found = read_surfaces(pixel);
        if found.near.y == 0u {
            continue;
        }
        for (var side = 0u; side < 2u; side++) {
            let key = select(found.near, found.far, side == 1u);
            let share = select(found.share, 1.0 - found.share, side == 1u);
            if key.y == 0u || share <= 0.0 {
                continue;
            }
            parts.shown += share;
            let w = inverse_depth_of(key.y);
            var same = 0u;
            for (; same < parts.count; same++) {
                let known = inverse_depth_of(parts.surfaces[same].key.y);
                // One sample is one surface, however slanted.
                if parts.surfaces[same].key.x == key.x || min(known, w) >= max(known, w) * stage.surface_ratio {
                    break;
                }
            }
            if same == parts.count {
                parts.surfaces[same].key = key;
                parts.count++;
            }
            parts.surfaces[same].share += share;
            parts.surfaces[same].at += share * vec2<f32>(pixel);
            parts.surfaces[same].w += share * w;
        }
    }
    return parts;
}

// Paints the pixel of the picture whose first sub-pixel this is, `local` in its block.
fn paint(first: vec2<u32>, local: vec2<u32>) {
    let parts = parts_of(first);
    let all = parts.shown;
    let subpixels = f32(stage.subpixels * stage.subpixels);
    let coverage = min(all / subpixels, 1.0);
    var farthest = bitcast<f32>(0x7f800000u);
    for (var nth = 0u; nth < parts.count; nth++) {
        farthest = min(farthest, parts.surfaces[nth].w / parts.surfaces[nth].share);
    }
    // What lies in front of the farthest surface.
    var before = 0.0;
    for (var nth = 0u; nth < parts.count; nth++) {
        let surface = parts.surfaces[nth];
        before += select(0.0, surface.share, surface.w / surface.share > farthest);
    }
    let has_front = parts.count > 1u;
    let slope = select(slope_around(local), vec2<f32>(0.0), has_front);
    // Most of what is shown lies in front of the farthest surface.
    let shows_front = has_front && 2.0 * before >= all;
    let near = near_cameras(local);
    var color = vec3<f32>(0.0);
    var front = vec3<f32>(0.0);
    var shown_key = vec2<u32>(0u);
    var shown_w = -1.0;
    var largest = 0.0;
    for (var nth = 0u; nth < parts.count; nth++) {
        let surface = parts.surfaces[nth];
        let w = surface.w / surface.share;
        let point = SurfacePoint(surface.at / surface.share, w, slope);
        let found = surface_color(surface.key, point, near);
        let is_front = has_front && w > farthest;
        color += surface.share / all * found;
        if is_front {
            front += surface.share / before * found;
        }
        if surface.share > largest && (is_front || !shows_front) && coverage >= LEAST_SHOWN {
            largest = surface.share;
            shown_key = surface.key;
            shown_w = w;
        }
    }
    let place = first / stage.subpixels;
    let pixel = place.y * (stage.width / stage.subpixels) + place.x;
    set_pixel(pixel, shown_key, shown_w, color);
    set_coverage(pixel, coverage);
    if stage.with_fronts == 1u {
        set_front(pixel, front, select(-1.0, farthest, has_front), select(0.0, before / subpixels, has_front));
    }
}

@compute @workgroup_size(16, 16)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    // The first threads take one pixel of the picture each, so that those that have none are idle together.
    let side = TILE / stage.subpixels;
    let local = vec2<u32>(thread % side, thread / side) * stage.subpixels;
    let first = group.xy * TILE + local;
    // Pixels of the background among its own samples; then those near a visible foreground, among all.
    for (var layer = 0u; layer < 2u; layer++) {
        let both = layer == 1u;
        if both && workgroupUniformLoad(&has_foreground) == 0u {
            break;
        }
        load_patch(group.xy, thread, both);
        find_near(group.xy, thread);
        if thread < side * side && is_painted(first, local, both) {
            paint(first, local);
        }
    }
}
