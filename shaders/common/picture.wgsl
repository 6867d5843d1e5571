// A resolved picture, in the order in which the CPU reads it: three words of color per pixel for all pixels, then inverse depths,
// then indices of images, then shares of pixels that are shown, then, if they are wanted, five words of what pixels show in front of
// their farthest surface. `picture` is bound by the stage. Twin: src/engine/render/vantage.rs.

// Marks a pixel that no sample reached.
const NO_IMAGE: u32 = 0xffffffffu;

// Sets a pixel to a sample, given by its key, at inverse depth `w`; to a hole where the key is 0.
fn set_pixel(pixel: u32, key: vec2<u32>, w: f32, color: vec3<f32>) {
    let pixels = picture_pixels();
    var image = NO_IMAGE;
    if key.y != 0u {
        image = pieces[piece_of(~key.x >> 8u)].image;
    }
    picture[3u * pixel] = bitcast<u32>(color.x);
    picture[3u * pixel + 1u] = bitcast<u32>(color.y);
    picture[3u * pixel + 2u] = bitcast<u32>(color.z);
    picture[3u * pixels + pixel] = bitcast<u32>(w);
    picture[4u * pixels + pixel] = image;
}

// Sets the share of a pixel that is shown. Only the gather stage knows it.
fn set_coverage(pixel: u32, coverage: f32) {
    picture[5u * picture_pixels() + pixel] = bitcast<u32>(coverage);
}

// Sets what a pixel shows in front of its farthest surface, the inverse depth of that one, negative if there is but one, and the share of
// the pixel that lies in front.
fn set_front(pixel: u32, color: vec3<f32>, w: f32, share: f32) {
    let at = 6u * picture_pixels() + 5u * pixel;
    picture[at] = bitcast<u32>(color.x);
    picture[at + 1u] = bitcast<u32>(color.y);
    picture[at + 2u] = bitcast<u32>(color.z);
    picture[at + 3u] = bitcast<u32>(w);
    picture[at + 4u] = bitcast<u32>(share);
}
