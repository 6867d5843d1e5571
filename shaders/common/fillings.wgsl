// What fills the pixels of holes, behind the masks: the share of the sky in each pixel, and six sums along its row.

const NOT_FILLED: f32 = -1.0;
// The line of sight was seen free: no surface is shown.
const ONLY_SKY: f32 = 2.0;

const SUM_WORDS: u32 = 6u;

fn sky_shares_at() -> u32 {
    return masks_at(SURFACE_SOURCES) * 2u;
}

fn sky_share_of(pixel: u32) -> f32 {
    return bitcast<f32>(masks[sky_shares_at() + pixel]);
}

fn set_sky_share(pixel: u32, share: f32) {
    masks[sky_shares_at() + pixel] = bitcast<u32>(share);
}

// Where the sums of a pixel begin.
fn sums_at(pixel: u32) -> u32 {
    return sky_shares_at() + pixel_count() + SUM_WORDS * pixel;
}
