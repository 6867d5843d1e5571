//! From Y′CbCr to red, green and blue, and back.
//!
//! Source: ITU-R BT.601 and BT.709. RVS, MPEG's reference view synthesizer, takes Y′CbCr for BT.601 over the full range of numbers,
//! as `OpenCV` does; cameras and broadcasters write BT.709 over a limited range. The manifest's `yuv_color` decides.

/// Weights and range of Y′CbCr.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColorMatrix {
    /// Weights of red and blue in luma.
    red: f32,
    blue: f32,
    /// Whether numbers run from 16/255 to 235/255 (240/255 for color).
    is_limited: bool,
}

impl Default for ColorMatrix {
    /// That of RVS.
    fn default() -> Self {
        Self { red: 0.299, blue: 0.114, is_limited: false }
    }
}

impl ColorMatrix {
    /// Names that the manifest knows.
    pub(crate) const NAMES: &str = "bt601_full, bt601_limited, bt709_full, bt709_limited";

    /// The matrix by its name in the manifest.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        let (weights, range) = name.split_once('_')?;
        let (red, blue) = match weights {
            "bt601" => (0.299, 0.114),
            "bt709" => (0.2126, 0.0722),
            _ => return None,
        };
        let is_limited = match range {
            "full" => false,
            "limited" => true,
            _ => return None,
        };
        Some(Self { red, blue, is_limited })
    }

    /// Encoded red, green and blue of luma and color, all 0 to 1, color 0.5 for gray.
    pub(crate) fn rgb(self, [y, u, v]: [f32; 3]) -> [f32; 3] {
        let (y, u, v) = if self.is_limited {
            ((y * 255.0 - 16.0) / 219.0, (u * 255.0 - 128.0) / 224.0, (v * 255.0 - 128.0) / 224.0)
        } else {
            (y, u - 0.5, v - 0.5)
        };
        let red = y + 2.0 * (1.0 - self.red) * v;
        let blue = y + 2.0 * (1.0 - self.blue) * u;
        let green = (y - self.red * red - self.blue * blue) / (1.0 - self.red - self.blue);
        [red, green, blue].map(|value| value.clamp(0.0, 1.0))
    }

    /// Luma and color of encoded red, green and blue.
    pub(crate) fn yuv(self, [red, green, blue]: [f32; 3]) -> [f32; 3] {
        let y = self.red * red + (1.0 - self.red - self.blue) * green + self.blue * blue;
        let u = (blue - y) / (2.0 * (1.0 - self.blue));
        let v = (red - y) / (2.0 * (1.0 - self.red));
        if self.is_limited {
            [(y * 219.0 + 16.0) / 255.0, (u * 224.0 + 128.0) / 255.0, (v * 224.0 + 128.0) / 255.0]
        } else {
            [y, u + 0.5, v + 0.5]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_matrix_undoes_itself_and_gray_has_no_color() {
        for name in ColorMatrix::NAMES.split(", ") {
            let matrix = ColorMatrix::from_name(name).unwrap();
            for rgb in [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.75], [1.0, 0.0, 0.0]] {
                let again = matrix.rgb(matrix.yuv(rgb));
                assert!(again.iter().zip(rgb).all(|(a, b)| (a - b).abs() < 1e-5), "{name} {rgb:?} {again:?}");
            }
            let gray = matrix.yuv([0.4; 3]);
            assert!((gray[1] - gray[2]).abs() < 1e-6 && (gray[1] - 0.5).abs() < 0.01, "{gray:?}");
        }
        assert_eq!(ColorMatrix::from_name("bt601_full"), Some(ColorMatrix::default()));
        assert!(ColorMatrix::from_name("bt2020_full").is_none() && ColorMatrix::from_name("bt601").is_none());
    }

    #[test]
    fn the_weights_are_the_published_ones() {
        // BT.601: R = Y + 1.402 Cr, B = Y + 1.772 Cb, G = Y − 0.344136 Cb − 0.714136 Cr.
        let rgb = ColorMatrix::default().rgb([0.5, 0.6, 0.4]);
        for (value, expected) in rgb.iter().zip([0.5 - 0.1402, 0.5 - 0.034_413_6 + 0.071_413_6, 0.5 + 0.1772])
        {
            assert!((value - expected).abs() < 1e-5, "{rgb:?}");
        }
    }
}
