//! Completes layers: normals where none are given, then footprints, ranks, packed geometry and packed color.

use glam::Vec3;
use rayon::prelude::*;

use super::flying_pixels::{BlendedTest, FlyingTest};
use super::layer::CameraLayer;
use super::packed_sample::{BLENDED_SKY, MIXED, PackedColor, PackedGeometry, Rank, UNKNOWN_NORMAL};
use super::sampling_rate::{Rate, ViewingRays, footprint, rank};
use crate::capture::Camera;
use crate::preprocess::normals::{DepthView, MIN_CONFIDENCE, estimate_at};
use crate::settings::{AgreementRule, MixedPixels, NormalSource, PruningMethod, Settings};

/// Fewer pixels are not worth a task of their own.
const MIN_PIXELS: usize = 1024;

/// What is needed to complete layers, decided once per capture and settings.
pub(crate) struct LayerBuilder<'a> {
    settings: &'a Settings,
    rate: Rate,
    antialiased: bool,
}

impl<'a> LayerBuilder<'a> {
    /// For a capture with these cameras, whose color is filtered across silhouettes if `antialiased`.
    pub(crate) fn new(settings: &'a Settings, cameras: &[Camera], antialiased: bool) -> Self {
        Self { settings, rate: Rate::resolve(settings.pruning.rate, cameras), antialiased }
    }

    /// Estimates the normals of the samples at `pixels`, where they are not given or not wanted as given.
    pub(crate) fn estimate_normals(&self, layer: &mut CameraLayer, camera: &Camera, pixels: &[u32]) {
        let rotation = camera.world_from_camera.matrix3.as_mat3();
        let view = DepthView::new(&layer.inverse_depth, camera, &self.settings.normals);
        let estimated = self.settings.normals.source == NormalSource::Estimated;
        let missing = |pixel: &u32| {
            let pixel = *pixel as usize;
            layer.inverse_depth[pixel] > 0.0 && (estimated || layer.normal[pixel] == Vec3::ZERO)
        };
        let estimate = |pixels: &[u32]| {
            let missing: Vec<u32> = pixels.iter().copied().filter(missing).collect();
            let estimates = estimate_at(&view, self.settings.normals.estimator, &missing);
            let normals = missing.into_iter().zip(estimates).map(|(pixel, estimate)| {
                let trusted = estimate.confidence >= MIN_CONFIDENCE;
                (pixel, if trusted { rotation * estimate.normal_in_camera } else { Vec3::ZERO })
            });
            normals.collect::<Vec<_>>()
        };
        let normals: Vec<(u32, Vec3)> = pixels.par_chunks(MIN_PIXELS).flat_map_iter(estimate).collect();
        for (pixel, normal) in normals {
            layer.normal[pixel as usize] = normal;
        }
    }

    /// Whether the settings treat mixed pixels other than clean ones.
    fn distinguishes_mixed(&self) -> bool {
        let pruning = &self.settings.pruning;
        match pruning.mixed_pixels {
            MixedPixels::Drop => true,
            // The first camera's samples yield to none, mixed or not.
            MixedPixels::Yield => pruning.method != PruningMethod::FirstCamera,
            MixedPixels::Keep => false,
        }
    }

    /// Fills in footprints, ranks, packed geometry and packed color of the samples at `pixels`, from colors, depths and normals.
    pub(crate) fn rate(&self, layer: &mut CameraLayer, camera: &Camera, pixels: &[u32]) {
        let width = layer.width.max(1);
        let rays = ViewingRays::new(camera);
        let camera_from_world = camera.camera_from_world().matrix3.as_mat3();
        let pruning = &self.settings.pruning;
        let edge = self.settings.normals.edge;
        let is_first_camera = pruning.method == PruningMethod::FirstCamera;
        let detects = self.distinguishes_mixed();
        let compares = pruning.method == PruningMethod::HighestRate;
        let blended = (detects && self.antialiased).then(|| BlendedTest::new(layer, camera, edge));
        // Other cameras decide what becomes of a flying pixel.
        let asks = pruning.agreement != AgreementRule::Off;
        let flying = (detects && asks).then(|| FlyingTest::new(layer, camera, edge));
        let rated = |&pixel: &u32| {
            let pixel = pixel as usize;
            let (x, y) = (pixel % width, pixel / width);
            let (inverse_depth, normal) = (layer.inverse_depth[pixel], layer.normal[pixel]);
            let ray = rays.at(x, y);
            let footprint = footprint(self.rate, &rays, ray, inverse_depth, normal, pruning);
            let is_flying = flying.as_ref().is_some_and(|test| test.is_flying(x, y));
            let mixed = is_flying || blended.as_ref().is_some_and(|test| test.is_blended(x, y));
            let unsure = normal == Vec3::ZERO && inverse_depth > 0.0;
            let unsure = if unsure { UNKNOWN_NORMAL } else { 0 };
            let rank = if is_first_camera { 0 } else { rank(footprint) | unsure };
            let blended_sky = if compares && inverse_depth == 0.0 { BLENDED_SKY } else { 0 };
            let rank = if mixed { rank | MIXED | blended_sky } else { rank };
            let normal_in_camera = camera_from_world * normal;
            let facet = PackedGeometry::new(inverse_depth, normal_in_camera);
            (
                footprint,
                rank,
                facet,
                PackedColor::new(layer.level[pixel], layer.color[pixel], normal != Vec3::ZERO)
                    .flying(is_flying),
            )
        };
        let rated: Vec<(f32, Rank, PackedGeometry, PackedColor)> =
            pixels.par_iter().with_min_len(MIN_PIXELS).map(rated).collect();
        for (&pixel, (footprint, rank, facet, look)) in pixels.iter().zip(rated) {
            // Not all layers keep footprints.
            if let Some(kept) = layer.footprint.get_mut(pixel as usize) {
                *kept = footprint;
            }
            layer.ranks[pixel as usize] = rank;
            layer.geometry[pixel as usize] = facet;
            layer.packed_colors[pixel as usize] = look;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::preprocess::temporal::ROOT;
    use glam::DVec3;

    #[test]
    fn a_sample_whose_normal_is_not_known_never_wins_against_one_whose_normal_is() {
        let lens = Intrinsics::from_horizontal_angle(2, 1, 0.9);
        let camera = Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        let mut layer = CameraLayer::empty(2, 1);
        for (pixel, (inverse_depth, normal)) in
            [(100.0, Vec3::ZERO), (0.001, Vec3::NEG_Y)].into_iter().enumerate()
        {
            layer.level[pixel] = ROOT;
            layer.inverse_depth[pixel] = inverse_depth;
            layer.normal[pixel] = normal;
        }
        let settings = Settings::default();
        LayerBuilder::new(&settings, std::slice::from_ref(&camera), false).rate(&mut layer, &camera, &[0, 1]);
        assert!(layer.ranks[0] > layer.ranks[1], "however near the first is");
    }
}
