// The average stage: a picture averaged over squares of a finer one. Twin: `averaged` in src/engine/render/supersample.rs.

struct Average {
    // Size of the averaged picture, pixels.
    width: u32,
    height: u32,
    // Pixels of the finer picture along each side of one of it.
    factor: u32,
    padding: u32,
}

const NO_IMAGE: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> average_of: Average;
// Columns and rows in a square, the nearest to its center first.
@group(0) @binding(1) var<storage, read> order: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> finer: array<u32>;
@group(0) @binding(3) var<storage, read_write> picture: array<u32>;

// Where the inverse depths and the images of the finer picture begin.
fn finer_pixels() -> u32 {
    return average_of.width * average_of.height * average_of.factor * average_of.factor;
}

fn is_sampled(pixel: u32) -> bool {
    return finer[4u * finer_pixels() + pixel] != NO_IMAGE;
}

// Whether a pixel shows a sample or the filling of a hole.
fn shows(pixel: u32) -> bool {
    return is_sampled(pixel) || bitcast<f32>(finer[3u * finer_pixels() + pixel]) >= 0.0;
}

@compute @workgroup_size(16, 16)
fn average(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= average_of.width || at.y >= average_of.height {
        return;
    }
    let across = average_of.width * average_of.factor;
    let first = at.y * average_of.factor * across + at.x * average_of.factor;
    let count = average_of.factor * average_of.factor;
    var sum = vec3<f32>(0.0);
    var sampled = 0u;
    var shown = 0u;
    // Nearest to the center, of those that show a sample and of the others that show anything.
    var middle_sampled = NO_IMAGE;
    var middle_filled = NO_IMAGE;
    for (var nth = 0u; nth < count; nth++) {
        let part = first + order[nth].y * across + order[nth].x;
        if !shows(part) {
            continue;
        }
        shown += 1u;
        sum += vec3<f32>(bitcast<f32>(finer[3u * part]), bitcast<f32>(finer[3u * part + 1u]), bitcast<f32>(finer[3u * part + 2u]));
        if is_sampled(part) {
            sampled += 1u;
            middle_sampled = min(middle_sampled, nth);
        } else {
            middle_filled = min(middle_filled, nth);
        }
    }
    var nth = NO_IMAGE;
    if 2u * sampled >= count {
        nth = middle_sampled;
    } else if 2u * shown >= count {
        nth = middle_filled;
    }
    let pixels = average_of.width * average_of.height;
    let pixel = at.y * average_of.width + at.x;
    var color = vec3<f32>(0.0);
    var inverse_depth = bitcast<u32>(-1.0);
    var image = NO_IMAGE;
    if nth != NO_IMAGE {
        let middle = first + order[nth].y * across + order[nth].x;
        color = sum / f32(shown);
        inverse_depth = finer[3u * finer_pixels() + middle];
        image = finer[4u * finer_pixels() + middle];
    }
    picture[3u * pixel] = bitcast<u32>(color.x);
    picture[3u * pixel + 1u] = bitcast<u32>(color.y);
    picture[3u * pixel + 2u] = bitcast<u32>(color.z);
    picture[3u * pixels + pixel] = inverse_depth;
    picture[4u * pixels + pixel] = image;
}
