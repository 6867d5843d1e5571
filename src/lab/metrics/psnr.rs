//! Peak signal-to-noise ratio, on sRGB-encoded values: `10 log₁₀ (1 / mean squared error)`.

/// The PSNR given for equal pictures, dB: JSON knows no infinity. 8-bit pictures that differ in one value of one pixel
/// among a million already reach 107 dB.
pub const MAX_PSNR_DB: f64 = 120.0;

/// PSNR in dB over the pixels named, for values whose peak is 1, at most [`MAX_PSNR_DB`]; `None` where no pixel is named.
#[must_use]
pub fn psnr_db(a: &[[f32; 3]], b: &[[f32; 3]], pixels: impl Iterator<Item = usize>) -> Option<f64> {
    let mean_squared_error = mean_squared_error(a, b, pixels)?;
    Some((-10.0 * mean_squared_error.log10()).min(MAX_PSNR_DB))
}

/// Mean of the squared differences of all channels of the pixels named; `None` if none is named.
pub(crate) fn mean_squared_error(
    a: &[[f32; 3]],
    b: &[[f32; 3]],
    pixels: impl Iterator<Item = usize>,
) -> Option<f64> {
    let mut count = 0_u64;
    let mut sum = 0.0;
    for pixel in pixels {
        for channel in 0..3 {
            let difference = f64::from(a[pixel][channel]) - f64::from(b[pixel][channel]);
            sum += difference * difference;
        }
        count += 3;
    }
    (count > 0).then(|| sum / count as f64)
}
