//! Random numbers that are the same in every run, on every machine and whatever the number of threads.

/// Mixes the bits of `seed`: `SplitMix64` by Sebastiano Vigna (2015).
#[must_use]
pub fn mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Two independent numbers between 0 and 1, the ends left out, from the bits of one that is mixed.
#[must_use]
pub fn uniform_pair(bits: u64) -> [f32; 2] {
    [bits, bits >> 32].map(|bits| ((bits & 0xff_ffff) as f32 + 0.5) / (1 << 24) as f32)
}

/// Two independent standard normal numbers from the bits of one that is mixed (George Box and Mervin Muller, 1958).
#[must_use]
pub fn gaussian_pair(bits: u64) -> [f32; 2] {
    let [share, turn] = uniform_pair(bits);
    let radius = (-2.0 * share.ln()).sqrt();
    let (sin, cos) = (std::f32::consts::TAU * turn).sin_cos();
    [radius * cos, radius * sin]
}
