// Sums of weighted colors in fixed point, so that their value does not depend on the order of the threads.
//
// Red, green, blue and weight of a pixel take 64 bits each, low word first, in units of 2⁻²⁸: a unit is a quarter of the
// rounding of an f32 of 1/16. What overflows is above 2³⁵, tens of thousands of samples of the largest half float in one pixel.
// Colors outside of the gamut are negative, and so may sums be: in two's complement.

const SUM_WORDS: u32 = 8u;
// Weights that sum to less, in units 4096, are no color.
const LEAST_WEIGHT: f32 = 0.0000152587890625;
const LARGEST_HALF: f32 = 65504.0;

fn negated(words: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(~words.x + 1u, ~words.y + select(0u, 1u, words.x == 0u));
}

// Of a number from −2³⁵ to 2³⁵, in units of 2⁻²⁸: low and high word. Every step is exact but the rounding.
fn fixed_point(value: f32) -> vec2<u32> {
    let units = round(abs(value) * 268435456.0);
    let high = floor(units * (1.0 / 4294967296.0));
    let words = vec2<u32>(u32(units - high * 4294967296.0), u32(high));
    return select(words, negated(words), value < 0.0);
}

fn floating_point(low: u32, high: u32) -> f32 {
    let is_negative = (high & 0x80000000u) != 0u;
    let words = select(vec2<u32>(low, high), negated(vec2<u32>(low, high)), is_negative);
    let size = f32(words.y) * 16.0 + f32(words.x) * (1.0 / 268435456.0);
    return select(size, -size, is_negative);
}
