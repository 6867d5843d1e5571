// A resolved picture, in the order in which the CPU reads it: three words of color per pixel for all pixels, then inverse depths,
// then indices of images. `picture` is bound by the stage. Twin: src/render/vantage.rs.

// Marks a pixel that no sample reached.
const NO_IMAGE: u32 = 0xffffffffu;

fn set_pixel(pixel: u32, key: vec2<u32>, color: vec3<f32>) {
    let pixels = stage.width * stage.height;
    var image = NO_IMAGE;
    if key.y != 0u {
        image = pieces[piece_of(~key.x >> 8u)].image;
    }
    picture[3u * pixel] = bitcast<u32>(color.x);
    picture[3u * pixel + 1u] = bitcast<u32>(color.y);
    picture[3u * pixel + 2u] = bitcast<u32>(color.z);
    picture[3u * pixels + pixel] = bitcast<u32>(inverse_depth_of(key.y));
    picture[4u * pixels + pixel] = image;
}
