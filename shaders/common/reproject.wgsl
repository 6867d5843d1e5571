// Carries surface points back into the cameras. Twins: src/engine/render/gather/reproject.rs, src/engine/render/gather/view_weights.rs.

// A higher sampling rate than this many times the vantage's gains nothing.
const USEFUL_RATE: f32 = 1.5;

// Cosines of incidence that differ by more than this factor count as differing by it.
const MOST_SLANTED: f32 = 0.02;

// A surface point in one camera.
struct Reprojected {
    inside: bool,
    // Whole column and row of the 2×2 samples around it, and its position between them, 0 to 1.
    corner: vec2<f32>,
    between: vec2<f32>,
    // Inverse depth of the point in the camera.
    expected: f32,
    // Distance from the vantage over that from the camera.
    distance_ratio: f32,
}

fn reproject(camera: u32, at: vec2<f32>, w: f32) -> Reprojected {
    let projector = views[camera].source_from_target;
    let point = ray(projector, at.x, at.y) + projector.origin * w;
    let distance_ratio = 1.0 / point.z;
    let pixel = point.xy * distance_ratio - 0.5;
    let size = vec2<f32>(f32(views[camera].width), f32(views[camera].height));
    let inside = point.z > 0.0 && all(pixel > vec2<f32>(-1.0)) && all(pixel < size);
    let corner = floor(pixel);
    return Reprojected(inside, corner, pixel - corner, w * distance_ratio, distance_ratio);
}

// Shares of left above, right above, left below, right below.
fn bilinear(between: vec2<f32>) -> array<f32, 4> {
    let back = 1.0 - between;
    return array<f32, 4>(back.x * back.y, between.x * back.y, back.x * between.y, between.x * between.y);
}

// Recorded pixels of a camera along a pixel of the picture.
fn rate_of(camera: u32, distance_ratio: f32) -> f32 {
    return views[camera].source_from_target.focal_ratio * distance_ratio * f32(stage.subpixels);
}

// The cosine between the lines of sight of the vantage and of a camera to a surface, and the squared lengths of both.
fn sights_of(camera: u32, at: vec2<f32>, w: f32) -> vec3<f32> {
    let line = stage.first_ray + stage.ray_across * at.x + stage.ray_down * at.y;
    let sight = line + views[camera].offset_in_world * w;
    let squared = vec2<f32>(dot(line, line), dot(sight, sight));
    return vec3<f32>(dot(line, sight) / sqrt(squared.x * squared.y), squared);
}

// The weight of a camera where nothing is known of the surface's slope: the squared sampling rate, up to USEFUL_RATE, times the cosine
// between its line of sight and the vantage's.
fn weight_of(camera: u32, distance_ratio: f32, at: vec2<f32>, w: f32) -> f32 {
    let rate = min(rate_of(camera, distance_ratio), USEFUL_RATE);
    return rate * rate * max(sights_of(camera, at, w).x, 0.01);
}

// The weight of a camera for a surface whose inverse depth `w` grows by `slope` a column and a row: the cubed sampling rate on the
// surface, else as above.
fn weight_on_surface(camera: u32, distance_ratio: f32, at: vec2<f32>, w: f32, slope: vec2<f32>) -> f32 {
    let sights = sights_of(camera, at, w);
    // The cosine of incidence over the vantage's.
    let growth = vec3<f32>(slope, w - slope.x * at.x - slope.y * at.y);
    let facing = (1.0 + dot(views[camera].growth_along_offset, growth)) * sqrt(sights.y / sights.z);
    let rate = min(rate_of(camera, distance_ratio) * sqrt(clamp(facing, MOST_SLANTED, 1.0 / MOST_SLANTED)), USEFUL_RATE);
    return rate * rate * rate * max(sights.x, 0.01);
}
