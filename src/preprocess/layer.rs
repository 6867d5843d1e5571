//! One camera at one frame, ready to be registered: every pixel's sample with its normal, footprint and facet.

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::facet::{Facet, Look, MIXED, Ranks, UNSURE};
use super::mixed_pixels::{MixedTest, snap};
use super::normals::{DepthView, MIN_CONFIDENCE};
use super::sampling_rate::{Rate, Rays, footprint, rank};
use crate::capture::{Camera, INVALID_INVERSE_DEPTH};
use crate::settings::{MixedPixels, NormalSource, PruningMethod, Settings};

/// Position on the way from the whole sequence to a single frame: 0 is the span of all frames, and every step down is a
/// shorter span inside the one before. A sample's level says when it is decided and what it is held against: samples of one
/// level are decided together, against each other and against those of the levels above, which are decided already.
pub type Level = u8;

/// The level of the span of all frames.
pub const ROOT: Level = 0;

/// In place of a level where there is no sample.
pub const NO_SAMPLE: Level = Level::MAX;

/// The samples of one camera, row-major planes of the camera's size.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Columns.
    pub width: usize,
    /// Linear color.
    pub color: Vec<[f16; 3]>,
    /// 1/z; 0 at infinity, negative where there is no sample.
    pub inverse_depth: Vec<f32>,
    /// Unit world-space normals; zero where unknown.
    pub normal: Vec<Vec3>,
    /// See [`footprint`]; infinite where there is no sample.
    pub footprint: Vec<f32>,
    /// How well each was sampled: the first that other cameras ask, …
    pub ranks: Vec<Ranks>,
    /// … where it lies, …
    pub facets: Vec<Facet>,
    /// … and how it looks.
    pub looks: Vec<Look>,
    /// The level of each pixel's sample; [`NO_SAMPLE`] where there is none.
    pub level: Vec<Level>,
    /// Noise of a single frame. Samples of one frame carry it.
    pub noise: super::noise::Noise,
    /// How much of [`Layer::noise`] is left in the samples of each level, 0 to 1; 0 for levels beyond the last.
    pub noise_share: Vec<f32>,
    /// Relative quantization step of depth.
    pub depth_step_relative: f32,
}

/// Fewer pixels are not worth a task of their own.
const MIN_PIXELS: usize = 1024;

/// What is needed to complete layers, decided once per capture and settings.
pub struct LayerBuilder<'a> {
    settings: &'a Settings,
    rate: Rate,
    antialiased: bool,
}

impl<'a> LayerBuilder<'a> {
    /// For a capture with these cameras, whose color is filtered across silhouettes if `antialiased`.
    #[must_use]
    pub fn new(settings: &'a Settings, cameras: &[Camera], antialiased: bool) -> Self {
        Self { settings, rate: Rate::resolve(settings.pruning.rate, cameras), antialiased }
    }

    /// Estimates the normals of the samples at `pixels`, where they are not given or not wanted as given.
    pub fn estimate_normals(&self, layer: &mut Layer, camera: &Camera, pixels: &[u32]) {
        let rotation = camera.world_from_camera.matrix3.as_mat3();
        let view = DepthView::new(&layer.inverse_depth, camera, &self.settings.normals);
        let estimated = self.settings.normals.source == NormalSource::Estimated;
        let missing = |pixel: &u32| {
            let pixel = *pixel as usize;
            layer.inverse_depth[pixel] > 0.0 && (estimated || layer.normal[pixel] == Vec3::ZERO)
        };
        let estimate = |pixels: &[u32]| {
            let missing: Vec<u32> = pixels.iter().copied().filter(missing).collect();
            let estimates = view.estimate_at(self.settings.normals.estimator, &missing);
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

    /// Fills in footprints, ranks, facets and looks of the samples at `pixels`, from colors, depths and normals.
    pub fn rate(&self, layer: &mut Layer, camera: &Camera, pixels: &[u32]) {
        let width = layer.width.max(1);
        let rays = Rays::new(camera);
        let camera_from_world = camera.camera_from_world().matrix3.as_mat3();
        let pruning = &self.settings.pruning;
        let edge = self.settings.normals.edge;
        let is_first_camera = pruning.method == PruningMethod::FirstCamera;
        let snaps = self.antialiased && pruning.mixed_pixels == MixedPixels::Snap;
        let snapped = if snaps { snap(layer, camera, edge, pixels) } else { Vec::new() };
        // The first camera's samples yield to none, blended or not. What was snapped makes edges of its own beside it, which
        // nobody recorded.
        let detects = match pruning.mixed_pixels {
            MixedPixels::Drop => self.antialiased,
            MixedPixels::Yield => self.antialiased && !is_first_camera,
            MixedPixels::Keep | MixedPixels::Snap => false,
        };
        let mixed = detects.then(|| MixedTest::new(layer, camera, edge));
        let rated = |&pixel: &u32| {
            let pixel = pixel as usize;
            let (x, y) = (pixel % width, pixel / width);
            let (inverse_depth, normal) = (layer.inverse_depth[pixel], layer.normal[pixel]);
            let ray = rays.at(x, y);
            let of = |rate| footprint(rate, &rays, ray, inverse_depth, normal, pruning);
            let own = of(self.rate);
            let mixed = !is_first_camera && snapped.binary_search(&(pixel as u32)).is_ok()
                || mixed.as_ref().is_some_and(|mixed| mixed.is_mixed(x, y));
            let ranks = [own, of(self.rate.other())].map(|footprint| {
                let unsure = normal == Vec3::ZERO && inverse_depth > 0.0;
                let unsure = if unsure { UNSURE } else { 0 };
                let rank = if is_first_camera { 0 } else { rank(footprint) | unsure };
                if mixed { rank | MIXED } else { rank }
            });
            let normal_in_camera = camera_from_world * normal;
            let ranks = Ranks { rank: ranks[0], other_rank: ranks[1] };
            let facet = Facet::new(inverse_depth, normal_in_camera);
            (own, ranks, facet, Look::new(layer.level[pixel], layer.color[pixel], normal != Vec3::ZERO))
        };
        let rated: Vec<(f32, Ranks, Facet, Look)> =
            pixels.par_iter().with_min_len(MIN_PIXELS).map(rated).collect();
        for (&pixel, (footprint, ranks, facet, look)) in pixels.iter().zip(rated) {
            layer.footprint[pixel as usize] = footprint;
            layer.ranks[pixel as usize] = ranks;
            layer.facets[pixel as usize] = facet;
            layer.looks[pixel as usize] = look;
        }
    }
}

impl Layer {
    /// A layer of `width × height` pixels without any sample.
    #[must_use]
    pub fn empty(width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self {
            width,
            color: vec![[f16::ZERO; 3]; pixels],
            inverse_depth: vec![INVALID_INVERSE_DEPTH; pixels],
            normal: vec![Vec3::ZERO; pixels],
            footprint: vec![f32::INFINITY; pixels],
            ranks: vec![Ranks::ABSENT; pixels],
            facets: vec![Facet::ABSENT; pixels],
            looks: vec![Look::ABSENT; pixels],
            level: vec![NO_SAMPLE; pixels],
            noise: super::noise::Noise::default(),
            noise_share: Vec::new(),
            depth_step_relative: 0.0,
        }
    }

    /// Takes the sample at `pixel` away.
    pub fn clear(&mut self, pixel: usize) {
        self.color[pixel] = [f16::ZERO; 3];
        self.inverse_depth[pixel] = INVALID_INVERSE_DEPTH;
        self.normal[pixel] = Vec3::ZERO;
        self.footprint[pixel] = f32::INFINITY;
        self.ranks[pixel] = Ranks::ABSENT;
        self.facets[pixel] = Facet::ABSENT;
        self.looks[pixel] = Look::ABSENT;
        self.level[pixel] = NO_SAMPLE;
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.inverse_depth.len().checked_div(self.width).unwrap_or(0)
    }

    /// Whether any sample may hold color noise.
    #[must_use]
    pub fn has_color_noise(&self) -> bool {
        self.noise_share.iter().any(|share| *share > 0.0)
            && self.noise.color_steps.iter().any(|steps| *steps > 0.0)
    }

    /// Whether any sample may hold depth noise.
    #[must_use]
    pub fn has_depth_noise(&self) -> bool {
        self.noise_share.iter().any(|share| *share > 0.0) && self.noise.depth_relative > 0.0
    }

    /// Relative standard deviation of the depth noise left in the sample at `pixel`.
    #[must_use]
    pub fn depth_noise(&self, pixel: usize) -> f32 {
        self.noise_share_at(pixel) * self.noise.depth_relative
    }

    /// How much of the noise of a single frame is left in the sample at `pixel`.
    fn noise_share_at(&self, pixel: usize) -> f32 {
        self.noise_share.get(usize::from(self.level[pixel])).copied().unwrap_or(0.0)
    }

    /// Standard deviation of the color noise left in the sample at `pixel`, 8-bit sRGB steps.
    #[must_use]
    pub fn color_noise(&self, pixel: usize, steps: f32) -> f32 {
        let share = self.noise_share_at(pixel);
        if share == 0.0 { 0.0 } else { share * self.noise.color_at(steps) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use glam::DVec3;

    #[test]
    fn a_sample_whose_normal_is_not_known_never_wins_against_one_whose_normal_is() {
        let lens = Intrinsics::from_horizontal_angle(2, 1, 0.9);
        let camera = Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        let mut layer = Layer::empty(2, 1);
        for (pixel, (inverse_depth, normal)) in
            [(100.0, Vec3::ZERO), (0.001, Vec3::NEG_Y)].into_iter().enumerate()
        {
            layer.level[pixel] = ROOT;
            layer.inverse_depth[pixel] = inverse_depth;
            layer.normal[pixel] = normal;
        }
        let settings = Settings::default();
        LayerBuilder::new(&settings, std::slice::from_ref(&camera), false).rate(&mut layer, &camera, &[0, 1]);
        assert!(layer.ranks[0].rank > layer.ranks[1].rank, "however near the first is");
        assert!(layer.ranks[0].other_rank > layer.ranks[1].other_rank);
    }
}
