//! Splats as SPZ, version 3: 20 bytes a splat, then gzip.
//!
//! Source: Niantic's description of the format and its program, github.com/nianticlabs/spz. What differs: the bits behind the point are as
//! many as the scene leaves, where that program writes 12; and a scene whose splats are too small or too large for the format's radii
//! is written in a unit of ten, a hundred … or a tenth … of its own.

use glam::Quat;

use super::gaussian::{Gaussian, byte, packed};
use crate::error::{Error, Result};
use crate::page::gzipped;

const MAGIC: u32 = 0x5053_474e;
const VERSION: u32 = 3;

/// More than these are refused by the format's own program.
const MOST_SPLATS: usize = 10_000_000;

/// Bits of a coordinate, one of them its sign.
const BITS: i32 = 24;

/// Bits behind the point at most: readers shift a 32-bit number by them.
const MOST_FRACTIONAL_BITS: i32 = 28;

/// The natural logarithm of a radius is `byte / 16 − 10`.
const LEAST_LOG: f32 = -10.0;
const LOG_STEPS: f32 = 16.0;

/// The natural logarithm of the largest radius.
const MOST_LOG: f32 = 255.0 / LOG_STEPS + LEAST_LOG;

/// A radius in the surface is at least this many times the format's least one: a splat is then flat, whatever becomes of its thickness.
const LEAST_RADIUS: f32 = 2.0;

/// Effort of compression: higher ones take several times as long for some percent.
const LEVEL: i32 = 6;

/// An SPZ file, and how exact it is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spz {
    pub(super) bytes: Vec<u8>,
    /// Units of the file in a unit of the world: a power of ten.
    pub(super) scale: f64,
    /// By how much a coordinate differs at most from that of the sample, world units.
    pub(super) error: f64,
}

/// Packs splats; `name` is that of the capture, for errors.
///
/// # Errors
/// `Invalid` for more splats than readers take, and for a scene that is too wide for 24 bits.
pub(super) fn pack(splats: &[Gaussian], name: &str) -> Result<Spz> {
    if splats.len() > MOST_SPLATS {
        let what = format!(
            "is not written: readers of SPZ take at most {MOST_SPLATS} splats; lower them by --at-most-splats, or choose --format ply"
        );
        return Err(Error::invalid(name, what));
    }
    let scale = unit(splats);
    let farthest = splats.iter().map(|splat| splat.center.abs().max_element()).fold(0.0, f32::max);
    let Some(fractional_bits) = fractional_bits(f64::from(farthest) * scale) else {
        let what = "is not written: it is too wide for the 24 bits of SPZ; choose --format ply";
        return Err(Error::invalid(name, what));
    };
    let mut raw = Vec::with_capacity(16 + 20 * splats.len());
    for word in [MAGIC, VERSION, splats.len() as u32] {
        raw.extend(word.to_le_bytes());
    }
    // Degree of the harmonics, bits behind the point, flags, reserved.
    raw.extend([0, fractional_bits as u8, 0, 0]);
    let steps = scale * f64::from(fractional_bits).exp2();
    for splat in splats {
        for coordinate in splat.center.to_array() {
            raw.extend_from_slice(&((f64::from(coordinate) * steps).round() as i32).to_le_bytes()[..3]);
        }
    }
    raw.extend(splats.iter().map(|splat| byte(splat.opacity * 255.0)));
    raw.extend(splats.iter().flat_map(|splat| packed(splat.color)));
    let log_of_scale = scale.ln() as f32;
    raw.extend(splats.iter().flat_map(|splat| {
        splat.radii.to_array().map(|radius| byte((radius.ln() + log_of_scale - LEAST_LOG) * LOG_STEPS))
    }));
    raw.extend(splats.iter().flat_map(|splat| smallest_three(splat.rotation).to_le_bytes()));
    Ok(Spz { bytes: gzipped(&raw, LEVEL, name)?, scale, error: 0.5 / steps })
}

/// The bits behind the point that coordinates up to `farthest` leave; `None` where even whole numbers are too large.
fn fractional_bits(farthest: f64) -> Option<i32> {
    let most = f64::from(BITS - 1).exp2() - 1.0;
    (0..=MOST_FRACTIONAL_BITS).rev().find(|bits| farthest * f64::from(*bits).exp2() <= most)
}

/// The power of ten that brings the radii into the range of the format: all but the smallest hundredth must not fall below it, and no
/// large one above it where that leaves the choice.
fn unit(splats: &[Gaussian]) -> f64 {
    let mut radii: Vec<f32> = splats.iter().map(|splat| splat.radii.y).collect();
    if radii.is_empty() {
        return 1.0;
    }
    let nth = radii.len() / 100;
    let (_, &mut small, _) = radii.select_nth_unstable_by(nth, f32::total_cmp);
    let large = splats.iter().map(|splat| splat.radii.x).fold(0.0, f32::max);
    let tens = |log: f32| f64::from(log / std::f32::consts::LN_10);
    let up = tens(LEAST_LOG + LEAST_RADIUS.ln() - small.ln()).ceil().max(0.0);
    let down = tens(MOST_LOG - large.ln()).floor().min(0.0);
    10_f64.powf(if up > 0.0 { up } else { down })
}

/// A rotation in 32 bits: which of x, y, z, w is largest in the top two, then for each other a sign and 9 bits of its size in units of
/// √½ / 511. The largest is above 0.
fn smallest_three(rotation: Quat) -> u32 {
    let parts = rotation.to_array();
    let largest = (0..4).fold(0, |best, at| if parts[at].abs() > parts[best].abs() { at } else { best });
    let is_turned = parts[largest] < 0.0;
    let mut packed = largest as u32;
    for (_, part) in parts.into_iter().enumerate().filter(|(at, _)| *at != largest) {
        let size = (part.abs() * std::f32::consts::SQRT_2 * 511.0 + 0.5).min(511.0) as u32;
        packed = packed << 10 | u32::from((part < 0.0) != is_turned) << 9 | size;
    }
    packed
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn splats(centers: &[Vec3], radius: f32) -> Vec<Gaussian> {
        let splat = |center: &Vec3| Gaussian {
            center: *center,
            rotation: Quat::from_euler(glam::EulerRot::XYZ, 0.4, center.x, -1.0),
            radii: Vec3::new(2.0 * radius, radius, 0.01 * radius),
            color: [0.2, 0.4, 0.6],
            opacity: 0.99,
        };
        centers.iter().map(splat).collect()
    }

    /// Centers and radii of a file in world units, by the description alone.
    fn read(spz: &Spz, count: usize) -> Vec<(Vec3, Vec3)> {
        let length = u32::from_le_bytes(*spz.bytes.last_chunk().unwrap()) as usize;
        let mut raw = vec![0; length];
        libdeflater::Decompressor::new().gzip_decompress(&spz.bytes, &mut raw).unwrap();
        assert_eq!((raw.len(), raw[4], raw[8] as usize), (16 + 20 * count, 3, count));
        let steps = spz.scale * f64::from(raw[13]).exp2();
        let coordinate = |at: usize| {
            let bytes = [0, raw[at], raw[at + 1], raw[at + 2]];
            (f64::from(i32::from_le_bytes(bytes) >> 8) / steps) as f32
        };
        let radius = |at: usize| (f64::from(f32::from(raw[at]) / 16.0 - 10.0).exp() / spz.scale) as f32;
        let center = |nth: usize| Vec3::from([0, 3, 6].map(|byte| coordinate(16 + 9 * nth + byte)));
        let radii = |nth: usize| Vec3::from([0, 1, 2].map(|axis| radius(16 + 13 * count + 3 * nth + axis)));
        (0..count).map(|nth| (center(nth), radii(nth))).collect()
    }

    #[test]
    fn scenes_of_millimeters_of_meters_and_of_kilometers_keep_their_places_and_radii() {
        for size in [1e-3_f32, 1.0, 30.0, 1e4, 3e6] {
            let centers =
                [Vec3::new(size, -0.5 * size, 0.25 * size), Vec3::ZERO, Vec3::new(0.0, 0.1 * size, -size)];
            let splats = splats(&centers, size / 1000.0);
            let spz = pack(&splats, "scene").unwrap();
            assert!(spz.error <= f64::from(size) / 4e6, "{size}: {}", spz.error);
            for (found, splat) in read(&spz, 3).iter().zip(&splats) {
                let off = (found.0 - splat.center).abs().max_element();
                assert!(f64::from(off) <= spz.error * 1.01 + f64::from(size) * 1e-7, "{size}: {off}");
                // Steps of 1/16 in the logarithm.
                assert!((found.1.y / splat.radii.y).ln().abs() < 0.04, "{size}: {found:?}");
                assert!(found.1.z < 0.6 * found.1.y, "{size}: it is flat");
            }
        }
        assert_eq!(pack(&splats(&[Vec3::ONE], 1e-3), "room").unwrap().scale, 1.0);
    }

    #[test]
    fn what_is_too_wide_is_refused() {
        let said = pack(&splats(&[Vec3::splat(1e9)], 1.0), "scene").unwrap_err().to_string();
        assert!(said.starts_with("scene: is not written") && said.contains("24 bits"), "{said}");
    }

    #[test]
    fn rotations_come_back_from_their_smallest_three_parts() {
        for nth in 0..200 {
            let angles = [0.37, 0.73, 1.91].map(|step| step * nth as f32);
            let rotation = Quat::from_euler(glam::EulerRot::XYZ, angles[0], angles[1], angles[2]);
            let packed = smallest_three(rotation);
            let largest = (packed >> 30) as usize;
            let (mut parts, mut left, mut rest) = ([0.0; 4], packed, 1.0_f32);
            for at in (0..4).rev().filter(|at| *at != largest) {
                let size = (left & 511) as f32 / 511.0 * std::f32::consts::FRAC_1_SQRT_2;
                parts[at] = if left >> 9 & 1 == 1 { -size } else { size };
                (left, rest) = (left >> 10, rest - parts[at] * parts[at]);
            }
            parts[largest] = rest.max(0.0).sqrt();
            assert!(Quat::from_array(parts).dot(rotation).abs() > 0.99999, "{rotation}");
        }
    }
}
