// Carrying a surface point back into the cameras: its color there, and how they see it. Twin: src/render/gather.rs.

// Sampling rates beyond this many times that of the vantage gain nothing.
const USEFUL_RATE: f32 = 1.5;
// Where less than this share of a pixel is known by interpolation, the nearest sample's own color stands in …
const ENOUGH: f32 = 0.25;
// … and counts this much for each part that is lacking.
const OWN_SHARE: f32 = 0.2;
// Samples whose 2×2 neighbors lie on another surface count less than clean ones.
const BESIDE_EDGE: f32 = 0.3;
// Sub-pixels along each side of a pixel that is interpolated in a picture of higher sampling rate, at most.
const MAX_SUBPIXELS: f32 = 4.0;

// A surface point in one camera.
struct Place {
    inside: bool,
    // Whole column and row of the 2×2 samples around it, and where it lies between them.
    corner: vec2<f32>,
    between: vec2<f32>,
    // Inverse depth there, if it is the surface that the camera sees.
    expected: f32,
    // Distance from the vantage over that from the camera.
    reciprocal: f32,
}

// How one camera sees a surface point, as shares of the 2×2 samples around it; `weight` is 0 where it does not.
struct Sight {
    agree: f32,
    through: f32,
    silent: f32,
    weight: f32,
}

fn place_in(camera: u32, at: vec2<f32>, w: f32) -> Place {
    let projector = views[camera].source_from_target;
    let point = ray(projector, at.x, at.y) + projector.origin * w;
    let reciprocal = 1.0 / point.z;
    let pixel = point.xy * reciprocal - 0.5;
    let size = vec2<f32>(f32(views[camera].width), f32(views[camera].height));
    let inside = point.z > 0.0 && all(pixel > vec2<f32>(-1.0)) && all(pixel < size);
    let corner = floor(pixel);
    return Place(inside, corner, pixel - corner, w * reciprocal, reciprocal);
}

// Shares of left above, right above, left below, right below.
fn bilinear(between: vec2<f32>) -> array<f32, 4> {
    let back = 1.0 - between;
    return array<f32, 4>(back.x * back.y, between.x * back.y, back.x * between.y, between.x * between.y);
}

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

// How much a camera counts: the squared sampling rate, as far as it is of use, times the cosine between its line of sight
// and the vantage's.
fn weight_of(camera: u32, reciprocal: f32, at: vec2<f32>, w: f32) -> f32 {
    let line = stage.first_ray + stage.ray_across * at.x + stage.ray_down * at.y;
    let sight = line + views[camera].offset_in_world * w;
    let cosine = dot(line, sight) / sqrt(dot(line, line) * dot(sight, sight));
    let rate = min(views[camera].source_from_target.focal_ratio * reciprocal, USEFUL_RATE);
    return rate * rate * max(cosine, 0.01);
}

// Weighted color and weight; zeros where the camera does not know.
fn interpolate(camera: u32, place: Place, at: vec2<f32>, w: f32) -> vec4<f32> {
    let quad = quad_at(camera, i32(place.corner.x), i32(place.corner.y));
    let limit = place.expected * views[camera].tolerance;
    var shares = bilinear(place.between);
    var agrees: array<bool, 4>;
    var depth = 0.0;
    var known = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let found = quad.depth[corner];
        agrees[corner] = found >= 0.0 && abs(found - place.expected) <= limit;
        if agrees[corner] {
            known += shares[corner];
            depth += shares[corner] * found;
        }
    }
    if known < 1e-3 {
        return vec4<f32>(0.0);
    }
    shares = bilinear(corrected(camera, place, at, depth / known));
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
    return vec4<f32>(color, known) * weight;
}

// One camera's weighted color and weight.
fn answer(camera: u32, at: vec2<f32>, w: f32) -> vec4<f32> {
    let place = place_in(camera, at, w);
    if !place.inside {
        return vec4<f32>(0.0);
    }
    // Where the picture is coarser than the camera's: the mean over sub-pixels, or fine detail would alias. One sub-pixel is
    // the pixel itself.
    let rate = views[camera].source_from_target.focal_ratio * place.reciprocal;
    let count = clamp(ceil(rate / USEFUL_RATE), 1.0, MAX_SUBPIXELS);
    let per_subpixel = 1.0 / count;
    var sum = vec4<f32>(0.0);
    for (var nth = 0u; nth < u32(count * count); nth++) {
        let sub = vec2<f32>(f32(nth % u32(count)), f32(nth / u32(count)));
        let sub_at = at + (sub + 0.5) * per_subpixel - 0.5;
        let sub_place = place_in(camera, sub_at, w);
        if sub_place.inside {
            sum += interpolate(camera, sub_place, sub_at, w);
        }
    }
    return sum * (per_subpixel * per_subpixel);
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
