// The blend stage: weighted sums of the colors of all samples of the nearest surface. Twin: src/engine/render/splat/blend.rs.

@group(1) @binding(0) var<storage, read_write> keys: array<u32>;
@group(1) @binding(1) var<storage, read_write> sums: array<atomic<u32>>;

// Variance of the reconstruction filter, squared source pixels, and of the screen filter, squared target pixels.
const SOURCE_VARIANCE: f32 = 0.15;
const SCREEN_VARIANCE: f32 = 0.1;
// The squared distance, in standard deviations, at which a footprint's weight has fallen to 0.
const KERNEL_END: f32 = 6.0;
// Footprints reach no farther, in target pixels.
const MAX_REACH: f32 = 64.0;
// How far a sample's weight reaches: in target pixels, and in projected source pixels.
const REACH_PIXELS: f32 = 1.5;
const REACH_SOURCE_PIXELS: f32 = 2.0 * MAX_STRETCH;
// The weight of samples beside another surface.
const BESIDE_EDGE: f32 = 0.5;
// The least weight of a line of sight.
const LEAST_COSINE: f32 = 0.01;

fn add_part(at: u32, value: f32) {
    let part = fixed_point(value);
    let before = atomicAdd(&sums[at], part.x);
    let carried = part.y + select(0u, 1u, before + part.x < before);
    if carried != 0u {
        atomicAdd(&sums[at + 1u], carried);
    }
}

fn add(x: u32, y: u32, depth: f32, weight: f32, color: vec3<f32>) {
    let pixel = y * stage.width + x;
    let nearest = inverse_depth_of(keys[2u * pixel + 1u]);
    // Neither what lies behind the surface, nor a nearer sample whose kernel only touches the edge of the pixel.
    let shown = depth >= nearest * stage.surface_ratio && depth * stage.surface_ratio <= nearest;
    if weight > 0.0 && shown {
        let at = SUM_WORDS * pixel;
        add_part(at, color.x * weight);
        add_part(at + 2u, color.y * weight);
        add_part(at + 4u, color.z * weight);
        add_part(at + 6u, weight);
    }
}

fn add_block(projected: Projected, w: f32, color: vec3<f32>) {
    let corner = floor(projected.pixel - 0.5);
    let share = projected.pixel - 0.5 - corner;
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<f32>(f32(i & 1u), f32(i >> 1u));
        let place = corner + step;
        if all(place >= vec2<f32>(0.0)) && place.x < f32(stage.width) && place.y < f32(stage.height) {
            let shares = select(1.0 - share, share, step > vec2<f32>(0.5));
            add(u32(place.x), u32(place.y), w * projected.reciprocal, shares.x * shares.y, color);
        }
    }
}

// World-space direction of a point of the picture before the division.
fn direction(image: vec3<f32>) -> vec3<f32> {
    let corner = stage.first_ray - 0.5 * (stage.ray_across + stage.ray_down);
    return stage.ray_across * image.x + stage.ray_down * image.y + corner * image.z;
}

// Cosine between the camera's and the vantage's lines of sight to a sample; `image` is its ray in the picture.
fn cosine(image: vec3<f32>, projected: Projected) -> f32 {
    let from_camera = direction(image);
    let from_vantage = direction(vec3<f32>(projected.pixel, 1.0));
    let lengths = sqrt(dot(from_camera, from_camera) * dot(from_vantage, from_vantage));
    return max(dot(from_camera, from_vantage) / lengths, LEAST_COSINE);
}

fn add_footprint(projected: Projected, found: Footprint, focal_ratio: f32, trust: f32, color: vec3<f32>) {
    let a = found.jacobian.x;
    let b = found.jacobian.y;
    let c = found.jacobian.z;
    let d = found.jacobian.w;
    let xx = SOURCE_VARIANCE * (a * a + b * b) + SCREEN_VARIANCE;
    let yy = SOURCE_VARIANCE * (c * c + d * d) + SCREEN_VARIANCE;
    let xy = SOURCE_VARIANCE * (a * c + b * d);
    let area = max(abs(a * d - b * c), 0.05);
    let determinant = xx * yy - xy * xy;
    let reach = min(REACH_PIXELS + REACH_SOURCE_PIXELS * focal_ratio * projected.reciprocal, MAX_REACH);
    let half_size = min(sqrt(KERNEL_END * vec2<f32>(xx, yy)), vec2<f32>(reach));
    let edges = edges_around(projected.pixel, half_size);
    for (var y = edges.z; y <= edges.w; y++) {
        for (var x = edges.x; x <= edges.y; x++) {
            let off = vec2<f32>(f32(x), f32(y)) + 0.5 - projected.pixel;
            let q = (yy * off.x * off.x - 2.0 * xy * off.x * off.y + xx * off.y * off.y) / determinant;
            let share = max(1.0 - q / KERNEL_END, 0.0);
            let depth = found.inverse_depth + found.slope.x * off.x + found.slope.y * off.y;
            add(u32(x), u32(y), depth, share * share * trust / area, color);
        }
    }
}

@compute @workgroup_size(16, 16)
fn blend(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let nth = group.y * GROUPS_ACROSS + group.x;
    if nth >= stage.tile_count {
        return;
    }
    let number = stage.first_tile + nth;
    let piece = pieces[piece_of(number)];
    let pixel = lay_out(piece, number, local.xy);
    let w = pixel.inverse_depth;
    let projector = projectors[piece.camera];
    let projected =
        project(projector, pixel.corner.x, pixel.corner.y + f32(local.y), f32(local.x), w);
    if w < 0.0 || !is_seen(projected) {
        return;
    }
    let color = clamp(unpack_color(piece, pixel.index), vec3<f32>(-LARGEST_HALF), vec3<f32>(LARGEST_HALF));
    if stage.kernel == KERNEL_SURFEL {
        let found = footprint(projector, projected, w, slopes(local.xy, projector.per_footprint));
        let image =
            ray(projector, pixel.corner.x, pixel.corner.y + f32(local.y)) + projector.per_column * f32(local.x);
        let beside = beside_edge(local.xy, projector.per_footprint);
        let trust = cosine(image, projected) * select(1.0, BESIDE_EDGE, beside);
        add_footprint(projected, found, projector.focal_ratio, trust, color);
    } else {
        add_block(projected, w, color);
    }
}
