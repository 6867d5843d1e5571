//! Picking: from a pixel of a rendered picture back to the sample that painted it.
//!
//! A picture holds for every pixel which image's sample is nearest and at which depth. The surface point there, projected into
//! the image's own camera, is beside the sample, which is the nearest of those around it.

use glam::{DVec2, DVec3};

use crate::render::vantage::{NO_IMAGE, Picture, Vantage};
use crate::samples::SampleSet;

/// The sample is searched this many pixels around the position: a footprint seen from the side reaches that far; the second
/// distance covers gaps between samples that gathering closed.
const REACHES: [i64; 2] = [3, 12];

/// The sample that painted a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickedSample {
    /// Index in [`SampleSet::images`].
    pub image: usize,
    /// Index of the camera in [`SampleSet::cameras`].
    pub camera: usize,
    /// Column of the sample in its camera's picture.
    pub x: usize,
    /// Row of the sample in its camera's picture.
    pub y: usize,
    /// Index of the sample in the planes of its image.
    pub index: usize,
    /// The surface point that the pixel shows, world space; `None` at infinity.
    pub point_in_world: Option<DVec3>,
}

/// The sample that painted pixel `(x, y)` of `picture`, which `samples` gave at `vantage`; `None` in holes.
#[must_use]
pub fn pick(
    samples: &SampleSet,
    vantage: &Vantage,
    picture: &Picture,
    x: usize,
    y: usize,
) -> Option<PickedSample> {
    let image_index = *picture.image.get(x, y)?;
    if image_index == NO_IMAGE {
        return None;
    }
    let image = samples.images.get(image_index as usize)?;
    let source = samples.cameras.get(image.camera as usize)?;
    let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
    let inverse_depth = f64::from(picture.inverse_depth[(x, y)]);
    let point = (inverse_depth > 0.0).then(|| vantage.camera.unproject(pixel, 1.0 / inverse_depth));
    let position = if let Some(point) = point {
        source.project(point)?.0
    } else if source.intrinsics.is_orthographic() {
        // All of its sky is in one direction: no pixel of it stands for this one.
        return None;
    } else {
        let direction =
            vantage.camera.world_from_camera.matrix3 * vantage.camera.intrinsics.ray_in_camera(pixel);
        source.intrinsics.project(source.camera_from_world().matrix3 * direction)?
    };
    let (column, row) = (position.x.floor() as i64, position.y.floor() as i64);
    let nearest = |reach: i64| {
        let rows = row - reach..=row + reach;
        let around = rows.flat_map(|y| (column - reach..=column + reach).map(move |x| (x, y)));
        let found = around.filter_map(|(x, y)| {
            let (column, row) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
            let (index, sample_inverse_depth) = image.sample_at(column, row)?;
            let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let distance = match point {
                Some(point) if sample_inverse_depth > 0.0 => {
                    (source.unproject(center, 1.0 / f64::from(sample_inverse_depth)) - point).length()
                }
                // A sample at infinity never shows a finite point.
                Some(_) => return None,
                None => (center - position).length(),
            };
            Some((distance, x as usize, y as usize, index))
        });
        found.min_by(|(a, ..), (b, ..)| a.total_cmp(b))
    };
    let (_, x, y, index) = REACHES.into_iter().find_map(nearest)?;
    Some(PickedSample {
        image: image_index as usize,
        camera: image.camera as usize,
        x,
        y,
        index,
        point_in_world: point,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use half::f16;

    use super::*;
    use crate::capture::{Camera, Intrinsics};
    use crate::samples::{DepthPlane, SampleImage, SampleTile, Span, TILE};
    use crate::settings::Settings;

    #[test]
    fn a_finite_point_is_never_said_to_be_shown_by_sky_that_lies_nearer() {
        let lens = Intrinsics::from_horizontal_angle(16, 16, 1.0);
        let camera = Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        let mut rows = [0; TILE];
        rows[8] = 1 << 7 | 1 << 13;
        let tiles = vec![SampleTile { tile_x: 0, tile_y: 0, first: 0, rows }];
        let image = SampleImage {
            camera: 0,
            span: Span { start: 0, end: 1 },
            color: vec![[f16::ONE; 3]; 2],
            depth: DepthPlane::pack(&tiles, &[0.0, 0.5]),
            normal: None,
            doubtful: Vec::new(),
            tiles,
            values: crate::capture::Values::default(),
        };
        let samples = SampleSet {
            name: "test".to_owned(),
            cameras: vec![camera.clone()],
            frame_numbers: vec![0],
            up_in_world: DVec3::Z,
            settings: Settings::default(),
            images: vec![Arc::new(image)],
            values: Vec::new(),
        };
        let vantage = Vantage { camera, frame: 0 };
        let mut picture = Picture::empty(16, 16);
        picture.image[(8, 8)] = 0;
        let mut picked = |inverse_depth: f32| {
            picture.inverse_depth[(8, 8)] = inverse_depth;
            pick(&samples, &vantage, &picture, 8, 8).map(|picked| (picked.x, picked.point_in_world.is_some()))
        };
        assert_eq!(picked(0.5), Some((13, true)));
        assert_eq!(picked(0.0), Some((7, false)));
    }
}
