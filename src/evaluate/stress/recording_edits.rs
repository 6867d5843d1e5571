//! Disturbances of the recording: each changes a frame as it is loaded.

use std::sync::Arc;

use half::f16;

use super::light::{Lighting, lit};
use super::shapes::Inserted;
use crate::capture::{Capture, Frame, FrameSource, INVALID_INVERSE_DEPTH};
use crate::demo::tracer::mix;
use crate::error::Result;
use crate::grid::Grid;

/// What is done to a frame.
pub(crate) enum Edit {
    /// Nothing.
    None,
    /// Relative standard deviation.
    DepthNoise(f32),
    /// Whole numbers of `bits` bits over a range of depth.
    DepthSteps {
        bits: f64,
        range: (f32, f32),
    },
    /// Bits of mantissa.
    DepthFloat {
        bits: u32,
    },
    /// Relative standard deviation.
    ColorNoise(f32),
    /// Radius of the filter, pixels.
    Antialiasing(f32),
    /// Share of 8×8 squares.
    NormalsMissing(f32),
    /// Standard deviation, radians.
    NormalsNoisy(f32),
    /// Frames that one camera is behind.
    OutOfSync {
        camera: usize,
        by: usize,
    },
    /// Stops between even and odd cameras.
    Exposure(f32),
    /// The last share of a camera's frames is missing.
    Missing {
        camera: usize,
        share: f64,
    },
    /// Share of the width and height that is seen.
    Narrow(f64),
    Inserted(Arc<Inserted>),
    Relit(Arc<Lighting>),
}

/// A capture whose frames are changed as they are loaded.
pub(crate) struct Edited {
    pub(crate) capture: Capture,
    pub(crate) edit: Edit,
}

impl FrameSource for Edited {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let source = match self.edit {
            Edit::OutOfSync { camera: late, by } if camera == late => frame.saturating_sub(by),
            _ => frame,
        };
        let mut recorded = (*self.capture.frame(camera, source)?).clone();
        let noise = PixelRandom { stream: seed(camera, frame) };
        match &self.edit {
            Edit::None | Edit::OutOfSync { .. } => {}
            Edit::DepthNoise(share) => depth_noise(&mut recorded, *share, &noise),
            Edit::DepthSteps { bits, range } => depth_steps(&mut recorded, *bits, *range),
            Edit::DepthFloat { bits } => depth_float(&mut recorded, *bits),
            Edit::ColorNoise(share) => color_noise(&mut recorded, *share, &noise),
            Edit::Antialiasing(radius_px) => antialias(&mut recorded, *radius_px),
            Edit::NormalsMissing(share) => normals_missing(&mut recorded, *share, camera),
            Edit::NormalsNoisy(radians) => normals_noisy(&mut recorded, *radians, &noise),
            Edit::Exposure(stops) => {
                let half = if camera.is_multiple_of(2) { -0.5 } else { 0.5 };
                let gain = (half * stops).exp2();
                for color in recorded.color.as_mut_slice() {
                    *color = color.map(|value| f16::from_f32(value.to_f32() * gain));
                }
            }
            Edit::Missing { camera: missing, share } => {
                let first_missing = self.capture.frame_count() as f64 * (1.0 - share);
                if camera == *missing && frame as f64 >= first_missing {
                    recorded.inverse_depth.as_mut_slice().fill(INVALID_INVERSE_DEPTH);
                }
            }
            Edit::Narrow(share) => narrow(&mut recorded, *share),
            Edit::Inserted(inserted) => {
                recorded = inserted.put_into(&self.capture.cameras[camera], recorded);
            }
            Edit::Relit(lighting) => {
                recorded = lit(lighting, &self.capture.cameras[camera], frame, recorded);
            }
        }
        Ok(recorded)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.capture.place(camera, frame)
    }
}

/// Frames of the same picture are told apart by this, so that noise is the same in every run.
fn seed(camera: usize, frame: usize) -> u64 {
    mix(mix(camera as u64) ^ frame as u64)
}

/// Random numbers that depend on camera, frame and pixel alone.
pub(crate) struct PixelRandom {
    stream: u64,
}

impl PixelRandom {
    /// Two independent standard normal numbers (George Box and Mervin Muller, 1958).
    fn gaussian_pair(&self, pixel: usize, salt: u64) -> [f32; 2] {
        let bits = mix(self.stream ^ mix(pixel as u64 ^ (salt << 48)));
        let uniform = |bits: u64| ((bits & 0xff_ffff) as f32 + 0.5) / (1 << 24) as f32;
        let radius = (-2.0 * uniform(bits).ln()).sqrt();
        let (sin, cos) = (std::f32::consts::TAU * uniform(bits >> 32)).sin_cos();
        [radius * cos, radius * sin]
    }
}

fn depth_noise(frame: &mut Frame, share: f32, noise: &PixelRandom) {
    for (pixel, inverse_depth) in frame.inverse_depth.as_mut_slice().iter_mut().enumerate() {
        if *inverse_depth > 0.0 {
            let factor = 1.0 + share * noise.gaussian_pair(pixel, 0)[0];
            *inverse_depth /= factor.max(0.1);
        }
    }
}

/// From this many bits on, whole numbers are as fine as the floats that depth comes in.
const EXACT_BITS: f64 = 24.0;

fn depth_steps(frame: &mut Frame, bits: f64, (near, far): (f32, f32)) {
    if bits >= EXACT_BITS {
        return;
    }
    let step = f64::from(far - near) / (bits.exp2() - 1.0);
    for inverse_depth in frame.inverse_depth.as_mut_slice() {
        if *inverse_depth > 0.0 {
            let steps = ((1.0 / f64::from(*inverse_depth) - f64::from(near)) / step).round();
            *inverse_depth = (1.0 / (f64::from(near) + steps.max(0.0) * step)) as f32;
        }
    }
}

fn depth_float(frame: &mut Frame, bits: u32) {
    let dropped = 23_u32.saturating_sub(bits);
    if dropped == 0 {
        return;
    }
    for inverse_depth in frame.inverse_depth.as_mut_slice() {
        if *inverse_depth > 0.0 {
            let depth = (1.0 / *inverse_depth).to_bits() + (1 << (dropped - 1));
            *inverse_depth = 1.0 / f32::from_bits(depth >> dropped << dropped);
        }
    }
    frame.depth_step_relative = frame.depth_step_relative.max((-(bits as f32) - 1.0).exp2());
}

/// As the demo's cameras: a deviation of `share · √(L (L + 0.02))`, two thirds of it common to all channels.
fn color_noise(frame: &mut Frame, share: f32, noise: &PixelRandom) {
    for (pixel, color) in frame.color.as_mut_slice().iter_mut().enumerate() {
        let [common, r] = noise.gaussian_pair(pixel, 1);
        let [g, b] = noise.gaussian_pair(pixel, 2);
        let own = [r, g, b];
        for channel in 0..3 {
            let value = color[channel].to_f32().max(0.0);
            let sigma = share * (value * (value + 0.02)).sqrt();
            let strayed = value + sigma * (0.816_5 * common + 0.577_35 * own[channel]);
            color[channel] = f16::from_f32(strayed.max(0.0));
        }
    }
}

/// Neighbors whose depths differ by more than this share have a silhouette between them.
const SILHOUETTE: f32 = 0.03;

/// Mixes the colors of pixels near a silhouette with a Gaussian of the given radius; depth stays as it is.
fn antialias(frame: &mut Frame, radius_px: f32) {
    if radius_px <= 0.0 {
        return;
    }
    let reach = (2.0 * radius_px).ceil() as i64;
    let (width, height) = frame.size();
    let (colors, depths) = (frame.color.clone(), &frame.inverse_depth);
    let around = |x: usize, y: usize, reach: i64| {
        let columns = (x as i64 - reach).max(0)..=(x as i64 + reach).min(width as i64 - 1);
        let rows = (y as i64 - reach).max(0)..=(y as i64 + reach).min(height as i64 - 1);
        rows.flat_map(move |row| columns.clone().map(move |column| (column as usize, row as usize)))
    };
    for y in 0..height {
        for x in 0..width {
            let here = depths[(x, y)];
            let is_edge = here >= 0.0
                && around(x, y, 1).any(|at| (depths[at] - here).abs() > SILHOUETTE * depths[at].max(here));
            if !is_edge {
                continue;
            }
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for at in around(x, y, reach) {
                let distance = (at.0 as f32 - x as f32).hypot(at.1 as f32 - y as f32) / radius_px;
                let weight = (-2.0 * distance * distance).exp();
                total += weight;
                for (sum, value) in sum.iter_mut().zip(colors[at]) {
                    *sum += weight * value.to_f32();
                }
            }
            frame.color[(x, y)] = sum.map(|value| f16::from_f32(value / total));
        }
    }
}

fn normals_missing(frame: &mut Frame, share: f32, camera: usize) {
    let width = frame.size().0;
    if let Some(normals) = &mut frame.normal_in_world {
        for (pixel, normal) in normals.as_mut_slice().iter_mut().enumerate() {
            let square = (pixel % width / 8, pixel / width / 8);
            let chance = mix(mix(camera as u64) ^ mix(square.0 as u64 ^ (square.1 as u64) << 32));
            if ((chance >> 40) as f32) < share * (1 << 24) as f32 {
                *normal = [0.0; 3];
            }
        }
    }
}

fn normals_noisy(frame: &mut Frame, radians: f32, noise: &PixelRandom) {
    let Some(normals) = frame.normal_in_world.as_mut().filter(|_| radians > 0.0) else { return };
    for (pixel, normal) in normals.as_mut_slice().iter_mut().enumerate() {
        let exact = glam::Vec3::from(*normal);
        if exact == glam::Vec3::ZERO {
            continue;
        }
        let [a, b] = noise.gaussian_pair(pixel, 3);
        let [c, _] = noise.gaussian_pair(pixel, 4);
        let off = exact + radians * glam::Vec3::new(a, b, c);
        *normal = off.normalize_or_zero().to_array();
    }
}

fn narrow(frame: &mut Frame, share: f64) {
    let (width, height) = frame.size();
    let inside = |at: usize, length: usize| ((at as f64 + 0.5) / length as f64 - 0.5).abs() <= 0.5 * share;
    let depths = &frame.inverse_depth;
    frame.inverse_depth = Grid::from_fn(width, height, |x, y| {
        if inside(x, width) && inside(y, height) { depths[(x, y)] } else { INVALID_INVERSE_DEPTH }
    });
}
