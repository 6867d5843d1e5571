//! What depth sensors get wrong: each changes the depth of a frame as it is loaded.
//!
//! Purpose: a renderer's depth is exact, and a sensor's is not. Source: the deviation that grows with the square of the depth, and is
//! shared by neighbors, is that of triangulation (K. Khoshelham and S. Oude Elberink, *Accuracy and Resolution of Kinect Depth
//! Data*, Sensors 2012); flying pixels are those of time of flight (M. Reynolds et al., *Capturing Time-of-Flight Data with
//! Confidence*, CVPR 2011). What differs: each is one number, so that it can be turned up alone.

use super::recording_edits::{FrameKey, PixelRandom, SILHOUETTE};
use overlook_engine::capture::{Capture, Frame, INVALID_INVERSE_DEPTH};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::median::median_f32;
use overlook_engine::random::mix;

/// One pixel in this many is used for the median depth.
const STRIDE: usize = 61;

/// Inverse of the median depth of all cameras' first frames; 0 where nothing has depth.
pub(super) fn median_inverse_depth(capture: &Capture) -> Result<f32> {
    let mut all = Vec::new();
    for camera in 0..capture.cameras.len() {
        let frame = capture.frame(camera, 0)?;
        let finite = frame.inverse_depth.as_slice().iter().step_by(STRIDE);
        all.extend(finite.filter(|inverse_depth| **inverse_depth > 0.0));
    }
    Ok(median_f32(&mut all).unwrap_or(0.0))
}

/// Pixels along which noise is correlated.
const CORRELATED_PX: usize = 3;

/// Noise changes the distance of a sample at most by this factor, in either direction.
const MOST_STRAYED: f32 = 10.0;

/// Gaussian noise in depth, in proportion to the square of the depth: it is the same everywhere in inverse depth, where `sigma`
/// is its deviation. Each pixel's is the mean over the 3×3 independent numbers around it.
pub(super) fn sensor_noise(frame: &mut Frame, sigma: f32, at: FrameKey) {
    if sigma <= 0.0 {
        return;
    }
    let random = PixelRandom::of(at);
    let (width, height) = frame.size();
    let (wide, high) = (width + CORRELATED_PX - 1, height + CORRELATED_PX - 1);
    let independent = Grid::from_fn(wide, high, |x, y| random.gaussian_pair(y * wide + x, 5)[0]);
    let across = Grid::from_fn(width, high, |x, y| {
        (x..x + CORRELATED_PX).map(|column| independent[(column, y)]).sum::<f32>()
    });
    // The sum of n × n independent numbers has n times the deviation of one.
    let scale = sigma / CORRELATED_PX as f32;
    for y in 0..height {
        for x in 0..width {
            let inverse_depth = &mut frame.inverse_depth[(x, y)];
            if *inverse_depth > 0.0 {
                let noise: f32 = (y..y + CORRELATED_PX).map(|row| across[(x, row)]).sum();
                let strayed = *inverse_depth + scale * noise;
                *inverse_depth = strayed.clamp(*inverse_depth / MOST_STRAYED, *inverse_depth * MOST_STRAYED);
            }
        }
    }
}

/// In front of the sky, flying pixels are at most this many times as far as the foreground.
const FARTHEST_FLIGHT: f32 = 2.0;

/// Puts a share of the pixels on both sides of depth steps in the air, anywhere between the foreground and the background.
pub(super) fn flying_pixels(frame: &mut Frame, share: f32, at: FrameKey) {
    if share <= 0.0 {
        return;
    }
    let random = PixelRandom::of(at);
    let (width, height) = frame.size();
    let recorded = frame.inverse_depth.clone();
    for y in 0..height {
        for x in 0..width {
            let here = recorded[(x, y)];
            if here < 0.0 {
                continue;
            }
            let (mut nearest, mut farthest) = (here, here);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                for column in x.saturating_sub(1)..(x + 2).min(width) {
                    let there = recorded[(column, row)];
                    if there >= 0.0 {
                        (nearest, farthest) = (nearest.max(there), farthest.min(there));
                    }
                }
            }
            let [chance, flight] = random.uniform_pair(y * width + x, 6);
            if nearest - farthest > SILHOUETTE * nearest && chance < share {
                let near = 1.0 / nearest;
                let far = (1.0 / farthest).min(FARTHEST_FLIGHT * near);
                frame.inverse_depth[(x, y)] = 1.0 / (near + flight * (far - near));
            }
        }
    }
}

/// What a camera takes the depth of a misread surface for, as a share of the true one: a pane that mirrors something before it,
/// and a mirror, which shows things behind it.
const MISREAD: [f32; 2] = [0.6, 1.5];

/// A camera misreads the middle of its picture, `share` of the width and of the height: too near in the left half, too far in the
/// right one.
pub(super) fn misread(frame: &mut Frame, share: f64) {
    let (width, height) = frame.size();
    let inside = |at: usize, length: usize| ((at as f64 + 0.5) / length as f64 - 0.5).abs() < 0.5 * share;
    for y in (0..height).filter(|y| inside(*y, height)) {
        for x in (0..width).filter(|x| inside(*x, width)) {
            let inverse_depth = &mut frame.inverse_depth[(x, y)];
            if *inverse_depth > 0.0 {
                *inverse_depth /= MISREAD[usize::from(2 * x >= width)];
            }
        }
    }
}

/// Side of a patch without depth, pixels.
const PATCH_PX: usize = 12;

/// A share of the depth is missing, in patches that are the same in every frame: surfaces too dark or too shiny for a sensor
/// stay so.
pub(super) fn depth_holes(frame: &mut Frame, share: f32, at: FrameKey) {
    let width = frame.size().0;
    for (pixel, inverse_depth) in frame.inverse_depth.as_mut_slice().iter_mut().enumerate() {
        let patch = (pixel % width / PATCH_PX, pixel / width / PATCH_PX);
        let chance = mix(mix(at.camera as u64 ^ (7 << 48)) ^ mix(patch.0 as u64 ^ (patch.1 as u64) << 32));
        if ((chance >> 40) as f32) < share * (1 << 24) as f32 {
            *inverse_depth = INVALID_INVERSE_DEPTH;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: FrameKey = FrameKey { camera: 1, frame: 2 };

    /// A near square before a far wall.
    fn frame(near: f32, far: f32) -> Frame {
        Frame {
            color: Grid::filled(96, 96, [half::f16::ONE; 3]),
            inverse_depth: Grid::from_fn(96, 96, |x, y| {
                if (32..64).contains(&x) && (32..64).contains(&y) { 1.0 / near } else { 1.0 / far }
            }),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: overlook_engine::capture::Values::default(),
        }
    }

    #[test]
    fn sensor_noise_grows_with_the_square_of_the_depth_and_is_shared_by_neighbors() {
        let recorded = frame(2.0, 8.0);
        let mut noisy = recorded.clone();
        sensor_noise(&mut noisy, 0.001, AT);
        let error = |at: (usize, usize)| 1.0 / noisy.inverse_depth[at] - 1.0 / recorded.inverse_depth[at];
        let deviation = |of: &dyn Fn(usize, usize) -> Option<f32>| {
            let all: Vec<f32> = (0..96 * 95).filter_map(|pixel| of(pixel % 96, pixel / 96)).collect();
            (all.iter().map(|value| value * value).sum::<f32>() / all.len() as f32).sqrt()
        };
        let is_near = |x: usize, y: usize| recorded.inverse_depth[(x, y)] > 0.4;
        let near = deviation(&|x, y| is_near(x, y).then(|| error((x, y))));
        let far = deviation(&|x, y| (!is_near(x, y)).then(|| error((x, y))));
        assert!((near - 0.004).abs() < 0.0006 && (far - 0.064).abs() < 0.006, "{near} {far}");
        // Two neighbors have six of nine numbers in common: their difference is √(2/3) as wide as each.
        let apart = deviation(&|x, y| {
            (!is_near(x, y) && !is_near(x, y + 1)).then(|| error((x, y)) - error((x, y + 1)))
        });
        assert!((apart / far - 0.816).abs() < 0.06, "{}", apart / far);
    }

    #[test]
    fn flying_pixels_are_at_depth_steps_between_foreground_and_background() {
        for far in [4.0, f32::INFINITY] {
            let recorded = frame(2.0, far);
            let mut flying = recorded.clone();
            flying_pixels(&mut flying, 0.5, AT);
            let mut moved = 0;
            for y in 0..96 {
                for x in 0..96 {
                    let (before, after) = (recorded.inverse_depth[(x, y)], flying.inverse_depth[(x, y)]);
                    if before != after {
                        let off = [x, y].map(|at| (at as f32 - 47.5).abs());
                        assert!(off[0].max(off[1]) > 14.0 && off[0].max(off[1]) < 17.0, "{x}, {y}");
                        assert!((0.25..=0.5).contains(&after), "{after}");
                        moved += 1;
                    }
                }
            }
            // Both sides of the square's outline have 256 pixels.
            assert!((95..160).contains(&moved), "{moved}");
        }
    }

    #[test]
    fn one_half_of_what_is_misread_is_too_near_and_the_other_too_far() {
        let mut misread_frame = frame(2.0, 2.0);
        misread(&mut misread_frame, 0.5);
        let depth = |x: usize| 1.0 / misread_frame.inverse_depth[(x, 48)];
        assert!((depth(30) - 1.2).abs() < 1e-5 && (depth(60) - 3.0).abs() < 1e-5);
        assert_eq!([depth(20), depth(80)], [2.0, 2.0]);
    }

    #[test]
    fn about_the_share_asked_for_has_no_depth_and_the_same_in_every_frame() {
        let holes = |at: FrameKey| {
            let mut frame = frame(2.0, 8.0);
            depth_holes(&mut frame, 0.5, at);
            frame.inverse_depth
        };
        let first = holes(AT);
        assert_eq!(first, holes(FrameKey { frame: 5, ..AT }));
        assert_ne!(first, holes(FrameKey { camera: 3, ..AT }));
        let missing = first.as_slice().iter().filter(|inverse_depth| **inverse_depth < 0.0).count();
        assert!((0.3..0.7).contains(&(missing as f32 / first.len() as f32)), "{missing}");
    }
}
