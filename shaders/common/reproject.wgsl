// Carrying a surface point back into the cameras. Twin: `Gather::places` in src/render/places.rs.

// Sampling rates beyond this many times that of the vantage gain nothing.
const USEFUL_RATE: f32 = 1.5;

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

// How much a camera counts: the squared sampling rate, as far as it is of use, times the cosine between its line of sight
// and the vantage's.
fn weight_of(camera: u32, reciprocal: f32, at: vec2<f32>, w: f32) -> f32 {
    let line = stage.first_ray + stage.ray_across * at.x + stage.ray_down * at.y;
    let sight = line + views[camera].offset_in_world * w;
    let cosine = dot(line, sight) / sqrt(dot(line, line) * dot(sight, sight));
    let rate = min(views[camera].source_from_target.focal_ratio * reciprocal, USEFUL_RATE);
    return rate * rate * max(cosine, 0.01);
}
