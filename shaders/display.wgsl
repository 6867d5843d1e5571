// The display stage: a picture as the window shows it, encoded for a display, with holes hatched that are not filled. It also counts the
// holes, filled or not.
// Twin: `colored` in src/desk/app/rooms/live/work/image.rs.

struct Display {
    // Size of the picture, pixels.
    width: u32,
    height: u32,
    // Width of the stripes over holes, pixels.
    stripe: u32,
    padding: u32,
    // Colors of the stripes, encoded.
    hole: vec4<f32>,
    hole_stripe: vec4<f32>,
}

const NO_IMAGE: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> display_of: Display;
@group(0) @binding(1) var<storage, read> picture: array<u32>;
@group(0) @binding(2) var<storage, read_write> holes: atomic<u32>;
@group(0) @binding(3) var screen: texture_storage_2d<rgba8unorm, write>;

fn srgb_from_linear(linear: vec3<f32>) -> vec3<f32> {
    let light = clamp(linear, vec3<f32>(0.0), vec3<f32>(1.0));
    let curve = 1.055 * pow(light, vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * light, light <= vec3<f32>(0.0031308));
}

@compute @workgroup_size(16, 16)
fn display(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= display_of.width || at.y >= display_of.height {
        return;
    }
    let pixels = display_of.width * display_of.height;
    let pixel = at.y * display_of.width + at.x;
    var color = select(display_of.hole_stripe, display_of.hole, (at.x + at.y) / display_of.stripe % 2u == 0u);
    if picture[4u * pixels + pixel] == NO_IMAGE {
        atomicAdd(&holes, 1u);
    }
    if bitcast<f32>(picture[3u * pixels + pixel]) >= 0.0 {
        let linear = vec3<f32>(
            bitcast<f32>(picture[3u * pixel]),
            bitcast<f32>(picture[3u * pixel + 1u]),
            bitcast<f32>(picture[3u * pixel + 2u]),
        );
        color = vec4<f32>(srgb_from_linear(linear), 1.0);
    }
    textureStore(screen, at.xy, color);
}
