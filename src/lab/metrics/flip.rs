//! FLIP: the difference that a person sees who flips between two pictures.
//!
//! Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, *FLIP: A Difference Evaluator for
//! Alternating Images*, 2020 (LDR-FLIP), with the constants of the authors' code. In its steps: both pictures are filtered
//! by the contrast sensitivity of the eye at a given number of pixels per degree, and compared by the `HyAB` distance in a
//! Hunt-adjusted L*a*b*; edges and points of the unfiltered luminance are compared beside; where features differ, the color
//! difference counts more. What differs: nothing but the arithmetic. Every kernel is applied as the sum of separable ones
//! that it is, and colors come in as linear values, not rounded to 8 bits.

use rayon::prelude::*;

use overlook_engine::grid::Grid;

/// Pixels per degree of the authors' default observer: 0.7 m before a 0.7 m wide monitor of 3840 pixels.
pub const DEFAULT_PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_26;

const QC: f32 = 0.7;
const QF: f32 = 0.5;
const PC: f32 = 0.4;
const PT: f32 = 0.95;
/// Width of the feature kernels, degrees.
const FEATURE_WIDTH_DEGREES: f64 = 0.082;

/// Contrast sensitivity of the achromatic, red-green and blue-yellow channels: two Gaussians each, `(a, b)`.
const SENSITIVITY: [[(f64, f64); 2]; 3] =
    [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];
/// The widest `b` of [`SENSITIVITY`]: one radius serves all channels.
const WIDEST: f64 = 0.04;

/// Linear sRGB to XYZ, row by row, as the authors give it.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
/// Its inverse.
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_9],
    [-0.969_224_3, 1.875_93, 0.041_554_226],
    [0.055_639_42, -0.204_011_21, 1.057_149],
];
/// XYZ of white.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

type Color = [f32; 3];

/// The difference at every pixel, 0 to 1, of two pictures of one size in linear Rec.709 (clipped to 0 to 1 here), seen at
/// `pixels_per_degree`.
///
/// # Panics
/// If the sizes differ: the caller has compared them.
#[must_use]
pub fn flip(test: &Grid<Color>, reference: &Grid<Color>, pixels_per_degree: f64) -> Grid<f32> {
    assert_eq!(test.size(), reference.size(), "pictures of one size");
    if test.is_empty() {
        return Grid::default();
    }
    let (test, reference) = (ycxcz(test), ycxcz(reference));
    let (lab_test, lab_reference) =
        (perceived(&test, pixels_per_degree), perceived(&reference, pixels_per_degree));
    let (features_test, features_reference) =
        (features(&test, pixels_per_degree), features(&reference, pixels_per_degree));
    let largest = largest_difference();
    let values = (0..test.len()).into_par_iter().map(|pixel| {
        let (a, b) = (lab_test.as_slice()[pixel], lab_reference.as_slice()[pixel]);
        let color = redistributed(hyab(a, b).powf(QC), largest);
        let (a, b) = (features_test.as_slice()[pixel], features_reference.as_slice()[pixel]);
        let feature = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
        let feature = (std::f32::consts::FRAC_1_SQRT_2 * feature).powf(QF);
        color.powf(1.0 - feature)
    });
    Grid::from_vec(test.width(), test.height(), values.collect())
}

/// Spreads color differences over 0 to 1: those below a share of the largest get most of the range.
fn redistributed(difference: f32, largest: f32) -> f32 {
    let knee = PC * largest;
    if difference < knee {
        PT / knee * difference
    } else {
        PT + (difference - knee) / (largest - knee) * (1.0 - PT)
    }
}

/// The largest color difference: green against blue.
fn largest_difference() -> f32 {
    hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(QC)
}

fn hyab(a: Color, b: Color) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

fn multiplied(matrix: &[[f32; 3]; 3], [x, y, z]: Color) -> Color {
    matrix.map(|row| row[0] * x + row[1] * y + row[2] * z)
}

/// Linear color to the opponent space `YCxCz`, in which the eye's sensitivity is given.
fn ycxcz(linear: &Grid<Color>) -> Grid<Color> {
    linear.map(|color| {
        let xyz = multiplied(&XYZ_FROM_RGB, color.map(|value| value.clamp(0.0, 1.0)));
        let [x, y, z] = std::array::from_fn(|axis| xyz[axis] / WHITE[axis]);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    })
}

/// What the eye makes of the picture: filtered, and in Hunt-adjusted L*a*b*.
fn perceived(ycxcz: &Grid<Color>, pixels_per_degree: f64) -> Grid<Color> {
    let mut filtered = Grid::filled(ycxcz.width(), ycxcz.height(), [0.0; 3]);
    for (channel, gaussians) in SENSITIVITY.iter().enumerate() {
        let plane = ycxcz.map(|color| color[channel]);
        for kernel in spatial_kernels(gaussians, pixels_per_degree) {
            let part = separable(&plane, &kernel, &kernel);
            for (sum, value) in filtered.as_mut_slice().iter_mut().zip(part.as_slice()) {
                sum[channel] += value;
            }
        }
    }
    let values = filtered.as_slice().par_iter().map(|color| {
        let y = (color[0] + 16.0) / 116.0;
        let xyz = [(y + color[1] / 500.0) * WHITE[0], y * WHITE[1], (y - color[2] / 200.0) * WHITE[2]];
        hunt_lab(multiplied(&RGB_FROM_XYZ, xyz).map(|value| value.clamp(0.0, 1.0)))
    });
    Grid::from_vec(ycxcz.width(), ycxcz.height(), values.collect())
}

fn hunt_lab(linear: Color) -> Color {
    const DELTA: f32 = 6.0 / 29.0;
    let root = |value: f32| {
        if value > DELTA * DELTA * DELTA { value.cbrt() } else { value / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let xyz = multiplied(&XYZ_FROM_RGB, linear);
    let [x, y, z] = std::array::from_fn(|axis| root(xyz[axis] / WHITE[axis]));
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The square kernels whose sum is a channel's filter, each as the row whose outer product with itself it is.
fn spatial_kernels(gaussians: &[(f64, f64); 2], pixels_per_degree: f64) -> Vec<Vec<f32>> {
    use std::f64::consts::PI;
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64;
    let rows: Vec<(f64, Vec<f64>)> = gaussians
        .iter()
        .filter(|(a, _)| *a > 0.0)
        .map(|&(a, b)| {
            let value = |offset: i64| (-(PI * offset as f64 / pixels_per_degree).powi(2) / b).exp();
            (a * (PI / b).sqrt(), (-radius..=radius).map(value).collect())
        })
        .collect();
    let sum: f64 = rows.iter().map(|(weight, row)| weight * row.iter().sum::<f64>().powi(2)).sum();
    rows.into_iter()
        .map(|(weight, row)| {
            let factor = (weight / sum).sqrt();
            row.into_iter().map(|value| (factor * value) as f32).collect()
        })
        .collect()
}

/// How strongly there is an edge, and a point, at every pixel of the luminance.
fn features(ycxcz: &Grid<Color>, pixels_per_degree: f64) -> Grid<[f32; 2]> {
    let luminance = ycxcz.map(|color| (color[0] + 16.0) / 116.0);
    let sigma = 0.5 * FEATURE_WIDTH_DEGREES * pixels_per_degree;
    let radius = (3.0 * sigma).ceil() as i64;
    let gaussian = |offset: i64| (-(offset as f64).powi(2) / (2.0 * sigma * sigma)).exp();
    let smooth = normalized((-radius..=radius).map(gaussian).collect());
    let edge = normalized((-radius..=radius).map(|x| -x as f64 * gaussian(x)).collect());
    let point =
        normalized((-radius..=radius).map(|x| ((x as f64 / sigma).powi(2) - 1.0) * gaussian(x)).collect());
    let strength = |kernel: &[f32]| {
        let across = separable(&luminance, kernel, &smooth);
        let down = separable(&luminance, &smooth, kernel);
        let strength = across.as_slice().iter().zip(down.as_slice()).map(|(x, y)| x.hypot(*y));
        strength.collect::<Vec<f32>>()
    };
    let both = strength(&edge).into_iter().zip(strength(&point)).map(|(edge, point)| [edge, point]);
    Grid::from_vec(luminance.width(), luminance.height(), both.collect())
}

/// Scales positive weights to a sum of 1 and negative ones to −1.
fn normalized(weights: Vec<f64>) -> Vec<f32> {
    let positive: f64 = weights.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = -weights.iter().filter(|weight| **weight < 0.0).sum::<f64>();
    let scaled = |weight: f64| weight / if weight < 0.0 { negative } else { positive };
    weights.into_iter().map(|weight| scaled(weight) as f32).collect()
}

/// The plane filtered by one kernel along rows and another down columns; the border's values go on beyond it.
fn separable(plane: &Grid<f32>, along: &[f32], down: &[f32]) -> Grid<f32> {
    let (width, height) = plane.size();
    let mut rows = vec![0.0; plane.len()];
    rows.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let radius = along.len() / 2;
        let source = plane.row(y);
        let mut padded = vec![source[0]; radius];
        padded.extend_from_slice(source);
        padded.resize(width + 2 * radius, source[width - 1]);
        for (offset, weight) in along.iter().enumerate() {
            for (sum, value) in out.iter_mut().zip(&padded[offset..]) {
                *sum += weight * value;
            }
        }
    });
    let mut values = vec![0.0; plane.len()];
    values.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let radius = down.len() / 2;
        for (offset, weight) in down.iter().enumerate() {
            let row = (y + offset).saturating_sub(radius).min(height - 1);
            for (sum, value) in out.iter_mut().zip(&rows[row * width..]) {
                *sum += weight * value;
            }
        }
    });
    Grid::from_vec(width, height, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_do_not_differ_and_black_from_white_differs_most() {
        let picture = Grid::from_fn(40, 30, |x, y| [x as f32 / 40.0, y as f32 / 30.0, 0.3]);
        let same = flip(&picture, &picture, DEFAULT_PIXELS_PER_DEGREE);
        assert!(same.as_slice().iter().all(|difference| *difference == 0.0));
        let (black, white) = (Grid::filled(9, 9, [0.0; 3]), Grid::filled(9, 9, [1.0; 3]));
        let most = flip(&black, &white, DEFAULT_PIXELS_PER_DEGREE);
        assert!(most.as_slice().iter().all(|difference| (0.9..=1.0).contains(difference)));
    }

    #[test]
    fn from_farther_away_a_small_difference_is_seen_less() {
        let a = Grid::from_fn(64, 64, |x, y| [0.5 + 0.1 * ((x + y) % 2) as f32; 3]);
        let b = Grid::filled(64, 64, [0.55; 3]);
        let mean = |ppd: f64| flip(&a, &b, ppd).as_slice().iter().sum::<f32>();
        assert!(mean(100.0) < 0.7 * mean(20.0), "{} {}", mean(100.0), mean(20.0));
    }
}
