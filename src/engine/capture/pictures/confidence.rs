//! How sure a depth sensor is of each pixel.
//!
//! Source: Apple's `ARConfidenceLevel`, which is low, medium or high, as Stray Scanner and 3D Scanner App (0, 1, 2) and Polycam
//! (0, 127, 255) write it. Pixels below high are dropped where three tenths of the picture stay then, else those below medium: a
//! picture of far or dark things has few high ones, and would be empty.

use crate::capture::frame::INVALID_INVERSE_DEPTH;

/// "High" is required if at least this share of pixels stays.
const SHARE_OF_HIGH: f64 = 0.3;

/// Takes the inverse depth of pixels that the sensor is unsure of; `confidence` is of the same size.
pub(crate) fn drop_unsure(inverse_depth: &mut [f32], confidence: &[u8]) {
    let is_in_steps = confidence.iter().all(|level| *level <= 2);
    let (high, medium) = if is_in_steps { (2, 1) } else { (255, 127) };
    let sure = confidence.iter().filter(|level| **level >= high).count();
    let is_enough = sure as f64 >= SHARE_OF_HIGH * confidence.len() as f64;
    let least = if is_enough { high } else { medium };
    for (value, level) in inverse_depth.iter_mut().zip(confidence) {
        if *level < least {
            *value = INVALID_INVERSE_DEPTH;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(confidence: &[u8]) -> Vec<bool> {
        let mut values = vec![1.0; confidence.len()];
        drop_unsure(&mut values, confidence);
        values.iter().map(|value| *value >= 0.0).collect()
    }

    #[test]
    fn pixels_below_high_go_while_enough_stay() {
        assert_eq!(kept(&[2, 2, 1, 0]), [true, true, false, false]);
        assert_eq!(kept(&[255, 255, 127, 0]), [true, true, false, false]);
        assert_eq!(kept(&[1, 1, 1, 0, 2]), [true, true, true, false, true], "few are high");
    }
}
