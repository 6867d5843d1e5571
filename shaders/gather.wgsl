// The gather stage: the color of each surface that stands in a pixel, looked up in the cameras.
// Twins: `Gather::find` in src/render/gather_points.rs, `Scratch::gather` in src/render/gather_block.rs.
//
// One workgroup a block of 16×16 pixels, one thread a pixel.

// Where less than this share of a pixel is known by interpolation, the nearest sample's own color stands in …
const ENOUGH: f32 = 0.25;
// … and counts this much for each part that is lacking.
const OWN_SHARE: f32 = 0.2;
// Samples whose 2×2 neighbors lie on another surface count less than clean ones.
const BESIDE_EDGE: f32 = 0.3;
// No further camera is asked once this many pixels' worth of samples are known.
const MANY: f32 = 1.99;
const MANY_PRUNED: f32 = 0.99;
// Depths that differ by less than this part of the tolerance are taken as equal.
const EXACT: f32 = 0.005;
// A sub-pixel is at most this many samples wide.
const SUBPIXEL_WIDTH: f32 = 2.5;
// Sub-pixels along each side of a pixel that is interpolated in a picture of higher sampling rate, at most.
const MAX_SUBPIXELS: f32 = 4.0;

// Where between the 2×2 samples the pixel's line of sight meets the surface that the camera itself saw, at `depth`.
fn corrected(camera: u32, place: Place, at: vec2<f32>, depth: f32) -> vec2<f32> {
    let back = projectors[camera];
    let pixel = place.corner + place.between;
    let seen = ray(back, pixel.x, pixel.y) + back.origin * depth;
    let there = views[camera].source_from_target;
    let point = ray(there, at.x, at.y) * seen.z + there.origin * depth;
    let found = point.xy * (1.0 / point.z) - 0.5 - place.corner;
    let sound = seen.z > 0.0 && point.z > 0.0;
    return select(place.between, clamp(found, vec2<f32>(0.0), vec2<f32>(1.0)), sound);
}

// One camera's answer; zeros where it does not know.
struct Answer {
    // Color times weight, and weight.
    sum: vec4<f32>,
    // Share of the pixel that is known.
    known: f32,
}

fn interpolate(camera: u32, place: Place, at: vec2<f32>, w: f32) -> Answer {
    let quad = quad_at(camera, i32(place.corner.x), i32(place.corner.y));
    let limit = place.expected * views[camera].tolerance;
    var shares = bilinear(place.between);
    var agrees: array<bool, 4>;
    var shown: array<f32, 4>;
    for (var corner = 0u; corner < 4u; corner++) {
        let found = quad.depth[corner];
        agrees[corner] = found >= 0.0 && abs(found - place.expected) <= limit;
        shown[corner] = select(0.0, shares[corner], agrees[corner]);
    }
    var known = (shown[0] + shown[1]) + (shown[2] + shown[3]);
    if known < 1e-3 {
        return Answer();
    }
    let above = shown[0] * quad.depth[0] + shown[1] * quad.depth[1];
    let below = shown[2] * quad.depth[2] + shown[3] * quad.depth[3];
    let depth = (above + below) / known;
    // Where the camera agrees with the z-buffer to a small part of the tolerance, correcting moves nothing.
    if abs(depth - place.expected) > EXACT * limit {
        shares = bilinear(corrected(camera, place, at, depth));
    }
    var color = vec3<f32>(0.0);
    var beside = false;
    known = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        if agrees[corner] {
            color += shares[corner] * unpack_color(pieces[quad.piece[corner]], quad.index[corner]);
            known += shares[corner];
        } else if quad.depth[corner] >= 0.0 {
            beside = true;
        }
    }
    let weight = weight_of(camera, place.reciprocal, at, w) * select(1.0, BESIDE_EDGE, beside);
    return Answer(vec4<f32>(color, known) * weight, known);
}

fn answer(camera: u32, at: vec2<f32>, w: f32) -> Answer {
    let place = place_in(camera, at, w);
    var found: Answer;
    if !place.inside {
        return found;
    }
    // Where the picture is coarser than the camera's: the mean over sub-pixels, or fine detail would alias. One sub-pixel is
    // the pixel itself.
    let rate = views[camera].source_from_target.focal_ratio * place.reciprocal;
    let count = clamp(ceil(rate / SUBPIXEL_WIDTH), 1.0, MAX_SUBPIXELS);
    let per_subpixel = 1.0 / count;
    for (var nth = 0u; nth < u32(count * count); nth++) {
        let sub = vec2<f32>(f32(nth % u32(count)), f32(nth / u32(count)));
        let sub_at = at + (sub + 0.5) * per_subpixel - 0.5;
        let sub_place = place_in(camera, sub_at, w);
        if sub_place.inside {
            let part = interpolate(camera, sub_place, sub_at, w);
            found.sum += part.sum;
            found.known += part.known;
        }
    }
    let share = per_subpixel * per_subpixel;
    return Answer(found.sum * share, found.known * share);
}

// The color of the surface that `key` stands for in pixel `at`, among the cameras of the patch, the best first, and in a
// pruned set before them the camera of the nearest sample; that sample's own color where nothing can be interpolated.
fn surface_color(key: vec2<u32>, at: vec2<f32>) -> vec3<f32> {
    let w = inverse_depth_of(key.y);
    let pruned = stage.pruned != 0u;
    let many = select(MANY, MANY_PRUNED, pruned);
    let sample_camera = pieces[piece_of(~key.x >> 8u)].camera;
    var sum = vec4<f32>(0.0);
    var known = 0.0;
    var camera = sample_camera;
    var ask = pruned;
    var next = 0u;
    loop {
        if ask {
            let found = answer(camera, at, w);
            sum += found.sum;
            known += found.known;
        }
        if next == camera_count || known >= many {
            break;
        }
        camera = camera_list[next];
        ask = !pruned || camera != sample_camera;
        next += 1u;
    }
    if known < ENOUGH {
        let lack = select(1.0, (ENOUGH - known) * OWN_SHARE * sum.w / known, known > 0.0);
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
    let pixel = group.xy * TILE + local.xy;
    let at = vec2<f32>(pixel);
    // Pixels of the background among its own samples; then those beside which a foreground is seen, among all.
    for (var layer = 0u; layer < 2u; layer++) {
        let both = layer == 1u;
        if both && workgroupUniformLoad(&has_foreground) == 0u {
            break;
        }
        load_patch(group.xy, thread, both);
        if is_painted(pixel, local.xy, both) {
            let standing = get_standing(pixel.y * stage.width + pixel.x);
            var color = vec3<f32>(0.0);
            // One loop for both surfaces, so that compilers that inline everything have half as much to inline.
            for (var side = 0u; side < 2u; side++) {
                let key = select(standing.near, standing.far, side == 1u);
                let share = select(standing.share, 1.0 - standing.share, side == 1u);
                if key.y != 0u && share > 0.0 {
                    color += share * surface_color(key, at);
                }
            }
            let shows_far = standing.far.y != 0u && standing.share < 0.5;
            let key = select(standing.near, standing.far, shows_far);
            set_pixel(pixel.y * stage.width + pixel.x, key, color);
        }
    }
}
