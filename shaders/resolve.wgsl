// The resolve stage of kernels that do not gather: from keys and sums to a picture. Twin: `ResolveInput::blended`
// in src/engine/render/resolve/layers.rs.

@group(1) @binding(0) var<storage, read> background_keys: array<u32>;
@group(1) @binding(1) var<storage, read> background_sums: array<u32>;
@group(1) @binding(2) var<storage, read> foreground_keys: array<u32>;
@group(1) @binding(3) var<storage, read> foreground_sums: array<u32>;
@group(1) @binding(4) var<storage, read_write> picture: array<u32>;

fn background_sum(pixel: u32) -> vec4<f32> {
    let at = SUM_WORDS * pixel;
    return vec4<f32>(
        floating_point(background_sums[at], background_sums[at + 1u]),
        floating_point(background_sums[at + 2u], background_sums[at + 3u]),
        floating_point(background_sums[at + 4u], background_sums[at + 5u]),
        floating_point(background_sums[at + 6u], background_sums[at + 7u]),
    );
}

fn foreground_sum(pixel: u32) -> vec4<f32> {
    let at = SUM_WORDS * pixel;
    return vec4<f32>(
        floating_point(foreground_sums[at], foreground_sums[at + 1u]),
        floating_point(foreground_sums[at + 2u], foreground_sums[at + 3u]),
        floating_point(foreground_sums[at + 4u], foreground_sums[at + 5u]),
        floating_point(foreground_sums[at + 6u], foreground_sums[at + 7u]),
    );
}

@compute @workgroup_size(256)
fn resolve(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pixel = (group.y * GROUPS_ACROSS + group.x) * 256u + thread;
    let pixels = stage.width * stage.height;
    if pixel >= pixels {
        return;
    }
    let back = vec2<u32>(background_keys[2u * pixel], background_keys[2u * pixel + 1u]);
    let front = vec2<u32>(foreground_keys[2u * pixel], foreground_keys[2u * pixel + 1u]);
    let front_wins = front.y > back.y || (front.y == back.y && front.x > back.x);
    let key = select(back, front, front_wins);
    var color = vec3<f32>(0.0);
    if key.y != 0u {
        var sum = vec4<f32>(0.0);
        if stage.kernel != KERNEL_POINT {
            let limit = inverse_depth_of(key.y) * stage.surface_ratio;
            if inverse_depth_of(back.y) >= limit {
                sum += background_sum(pixel);
            }
            if inverse_depth_of(front.y) >= limit {
                sum += foreground_sum(pixel);
            }
        }
        if sum.w >= LEAST_WEIGHT {
            color = sum.xyz / sum.w;
        } else {
            color = color_of(~key.x);
        }
    }
    set_pixel(pixel, key, inverse_depth_of(key.y), color);
}
