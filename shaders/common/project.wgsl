// Projection and oriented footprints. Twins: src/engine/render/geometry/project.rs, src/engine/render/geometry/footprint.rs.

struct Projector {
    // `M·ray` of the center of pixel (0, 0).
    first_pixel: vec3<f32>,
    // Focal length of the target over that of the source.
    focal_ratio: f32,
    // Growth of `M·ray` from one column to the next.
    per_column: vec3<f32>,
    // Reciprocal focal length of the source: the size of its footprints at unit distance.
    per_footprint: f32,
    // Growth from one row to the next.
    per_row: vec3<f32>,
    padding_0: u32,
    // The source camera's center in the target, before the division.
    origin: vec3<f32>,
    padding_1: u32,
}

@group(0) @binding(1) var<storage, read> projectors: array<Projector>;

struct Projected {
    // Target pixel, centers at +0.5; meaningless where `reciprocal` is not positive.
    pixel: vec2<f32>,
    // 1 / P.z.
    reciprocal: f32,
}

fn ray(projector: Projector, x: f32, y: f32) -> vec3<f32> {
    return projector.first_pixel + projector.per_column * x + projector.per_row * y;
}

// Pixel `(x + along, y)` of the source at inverse depth `w`, summed in the order of the CPU.
fn project(projector: Projector, x: f32, y: f32, along: f32, w: f32) -> Projected {
    let point = ray(projector, x, y) + projector.per_column * along + projector.origin * w;
    let reciprocal = 1.0 / point.z;
    return Projected(point.xy * reciprocal, reciprocal);
}

// Whether the sample lies in front of the target camera, at a finite position: NaN must not bound a loop.
fn is_seen(projected: Projected) -> bool {
    return projected.reciprocal > 0.0 && all(abs(projected.pixel) < vec2<f32>(1e9));
}

struct Footprint {
    inverse_depth: f32,
    // Growth of the inverse depth from one target column and row to the next, and how far it may deviate in the footprint.
    slope: vec2<f32>,
    deviation: f32,
    // Jacobian of target pixels by source pixels: [∂u/∂column, ∂u/∂row, ∂v/∂column, ∂v/∂row], and its inverse.
    jacobian: vec4<f32>,
    inverse: vec4<f32>,
    half_size: vec2<f32>,
    // The largest half extent, also of the fringe.
    largest: f32,
}

// A footprint stretches at most to this many times its size seen face on.
const MAX_STRETCH: f32 = 1.5;
// Neighboring footprints overlap by this factor, so that no crack opens between them.
const OVERLAP: f32 = 1.05;
// How far a footprint reaches from its sample, in source pixels.
const CORE_REACH: f32 = 0.5 * OVERLAP;
// Samples at least this many pixels wide count as magnified.
const MAGNIFIED: f32 = 2.5;
// How far the fringe of a magnified sample reaches, in source pixels.
const FRINGE: f32 = 1.0;

fn footprint(projector: Projector, projected: Projected, w: f32, slopes: vec2<f32>) -> Footprint {
    let reciprocal = projected.reciprocal;
    let target_w = w * reciprocal;
    let across = projector.per_column + projector.origin * slopes.x;
    let down = projector.per_row + projector.origin * slopes.y;
    let columns = (across.xy - projected.pixel * across.z) * reciprocal;
    let rows = (down.xy - projected.pixel * down.z) * reciprocal;
    let a = columns.x;
    let b = rows.x;
    let c = columns.y;
    let d = rows.y;
    let w_across = (slopes.x - target_w * across.z) * reciprocal;
    let w_down = (slopes.y - target_w * down.z) * reciprocal;
    let determinant = a * d - b * c;
    // Edge on, the plane gives no depth in the target.
    var inverse = 0.0;
    if abs(determinant) > 1e-6 {
        inverse = 1.0 / determinant;
    }
    let largest = MAX_STRETCH * projector.focal_ratio * reciprocal;
    var found: Footprint;
    found.inverse_depth = target_w;
    found.slope = vec2<f32>(w_across * d - w_down * c, w_down * a - w_across * b) * inverse;
    found.deviation = CORE_REACH * (abs(w_across) + abs(w_down));
    found.jacobian = vec4<f32>(a, b, c, d);
    found.inverse = vec4<f32>(d, -b, -c, a) * inverse;
    found.half_size = min(CORE_REACH * vec2<f32>(abs(a) + abs(b), abs(c) + abs(d)), vec2<f32>(largest));
    found.largest = largest;
    return found;
}
