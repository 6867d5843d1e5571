//! One camera at one frame, ready to be registered: every pixel's sample with its normal, footprint and facet.

use std::sync::Arc;

use glam::Vec3;
use half::f16;

use super::packed_sample::{ABSENT_RANK, PackedColor, PackedGeometry, Rank};
use crate::capture::{Frame, INVALID_INVERSE_DEPTH, ValueChannel, Values};
use crate::preprocess::noise::{CameraNoise, NoiseBetween};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel, SpanSamples};

/// The samples of one camera, row-major planes of the camera's size.
#[derive(Clone, Debug, Default)]
pub struct CameraLayer {
    /// Columns.
    pub(crate) width: usize,
    /// Linear color.
    pub(crate) color: Vec<[f16; 3]>,
    /// 1/z; 0 at infinity, negative where there is no sample.
    pub(crate) inverse_depth: Vec<f32>,
    /// Unit world-space normals; zero where unknown.
    pub(crate) normal: Vec<Vec3>,
    /// See [`footprint`](super::sampling_rate::footprint); infinite where there is no sample.
    pub(crate) footprint: Vec<f32>,
    /// How well each was sampled; read first when cameras are compared.
    pub(crate) ranks: Vec<Rank>,
    /// Depth and normal of each; read second.
    pub(crate) geometry: Vec<PackedGeometry>,
    /// How each looks; read last.
    pub(crate) packed_colors: Vec<PackedColor>,
    /// The level of each pixel's sample; [`NO_SAMPLE`] without a sample.
    pub(crate) level: Vec<SpanLevel>,
    /// Scalar values; empty where the capture has none.
    pub(crate) values: Values,
    /// How far apart values of each channel may be to be the same.
    pub(crate) value_tolerances: Vec<f32>,
    /// Noise of a single frame. Samples of one frame carry it.
    pub(crate) noise: CameraNoise,
    /// How much of [`CameraLayer::noise`] is left in the samples of each level, 0 to 1; 0 for levels beyond the last.
    pub(crate) noise_share: Vec<f32>,
    /// Relative quantization step of depth.
    pub(crate) depth_step_relative: f32,
    /// Noise as other cameras see it; `None` where it was not measured or is too small to matter.
    pub(crate) noise_between: Option<Arc<NoiseBetween>>,
}

impl CameraLayer {
    /// A layer of `width × height` pixels without any sample.
    pub(crate) fn empty(width: usize, height: usize) -> Self {
        let pixels = width * height;
        let layer = Self { normal: vec![Vec3::ZERO; pixels], ..Self::default() };
        Self { footprint: vec![f32::INFINITY; pixels], ..layer.of_size(width, height) }
    }

    /// The same of a capture with these channels of scalar values.
    pub(crate) fn empty_for(width: usize, height: usize, channels: &[ValueChannel]) -> Self {
        let value_tolerances = channels.iter().map(|channel| channel.tolerance).collect();
        let values = Values::missing(channels.len(), width * height);
        Self { values, value_tolerances, ..Self::empty(width, height) }
    }

    /// What is known of the camera, with room for samples in `width × height` pixels, but for their normals and footprints.
    pub(crate) fn of_size(self, width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self {
            width,
            color: vec![[f16::ZERO; 3]; pixels],
            inverse_depth: vec![INVALID_INVERSE_DEPTH; pixels],
            ranks: vec![ABSENT_RANK; pixels],
            geometry: vec![PackedGeometry::ABSENT; pixels],
            packed_colors: vec![PackedColor::ABSENT; pixels],
            level: vec![NO_SAMPLE; pixels],
            values: Values::missing(self.value_tolerances.len(), pixels),
            ..self
        }
    }

    /// What is known of the camera without its samples: they take no memory, and the layer takes part in nothing.
    pub(crate) fn without_samples(&self) -> Self {
        Self {
            value_tolerances: self.value_tolerances.clone(),
            noise: self.noise.clone(),
            noise_share: self.noise_share.clone(),
            depth_step_relative: self.depth_step_relative,
            noise_between: self.noise_between.clone(),
            ..Self::default()
        }
    }

    /// Puts samples into the layer; they need normals and rates yet.
    pub(crate) fn put(&mut self, level: SpanLevel, samples: &SpanSamples) {
        for (index, &pixel) in samples.pixels.iter().enumerate() {
            let pixel = pixel as usize;
            self.level[pixel] = level;
            self.color[pixel] = samples.color[index];
            self.inverse_depth[pixel] = samples.inverse_depth[index];
            self.normal[pixel] = samples.normal.get(index).copied().unwrap_or(Vec3::ZERO);
            self.values.put(pixel, samples.values.of(index));
        }
    }

    /// Puts the frame's samples wherever the layer has none; they need normals and rates yet. Gives their pixels.
    pub(crate) fn put_frame(&mut self, level: SpanLevel, frame: &Frame) -> Vec<u32> {
        let mut pixels = Vec::new();
        for (pixel, &inverse_depth) in frame.inverse_depth.as_slice().iter().enumerate() {
            if self.level[pixel] != NO_SAMPLE || inverse_depth < 0.0 {
                continue;
            }
            self.level[pixel] = level;
            self.inverse_depth[pixel] = inverse_depth;
            self.color[pixel] = frame.color.as_slice()[pixel];
            if let Some(normals) = &frame.normal_in_world {
                self.normal[pixel] = Vec3::from(normals.as_slice()[pixel]);
            }
            self.values.put(pixel, frame.values.of(pixel));
            pixels.push(pixel as u32);
        }
        pixels
    }

    /// Takes the sample at `pixel` away.
    pub(crate) fn clear(&mut self, pixel: usize) {
        self.color[pixel] = [f16::ZERO; 3];
        self.inverse_depth[pixel] = INVALID_INVERSE_DEPTH;
        if let Some(normal) = self.normal.get_mut(pixel) {
            *normal = Vec3::ZERO;
        }
        if let Some(footprint) = self.footprint.get_mut(pixel) {
            *footprint = f32::INFINITY;
        }
        self.ranks[pixel] = ABSENT_RANK;
        self.geometry[pixel] = PackedGeometry::ABSENT;
        self.packed_colors[pixel] = PackedColor::ABSENT;
        self.level[pixel] = NO_SAMPLE;
    }

    /// Rows.
    pub(crate) fn height(&self) -> usize {
        self.inverse_depth.len().checked_div(self.width).unwrap_or(0)
    }

    /// Whether any sample may hold color noise, over time or between cameras.
    pub(crate) fn has_color_noise(&self) -> bool {
        let over_time = self.noise_share.iter().any(|share| *share > 0.0)
            && self.noise.color_steps.iter().any(|steps| *steps > 0.0);
        over_time || self.noise_between.is_some()
    }

    /// Whether any sample may hold depth noise over time.
    pub(crate) fn has_depth_noise(&self) -> bool {
        self.noise_share.iter().any(|share| *share > 0.0) && self.noise.depth_relative > 0.0
    }

    /// Relative standard deviation of the depth noise left in the sample at `pixel`.
    pub(crate) fn depth_noise(&self, pixel: usize) -> f32 {
        self.depth_noise_of(self.level[pixel])
    }

    /// Relative standard deviation of the depth noise left in samples of a level.
    pub(crate) fn depth_noise_of(&self, level: SpanLevel) -> f32 {
        self.noise_share_of(level) * self.noise.depth_relative
    }

    /// Relative standard deviation of the depth of the sample at `pixel` as other cameras see it.
    pub(crate) fn depth_noise_between(&self, pixel: usize) -> f32 {
        self.depth_noise_between_at(self.inverse_depth[pixel])
    }

    /// Relative standard deviation of an inverse depth of this camera as other cameras see it.
    pub(crate) fn depth_noise_between_at(&self, inverse_depth: f32) -> f32 {
        self.noise_between.as_ref().map_or(0.0, |noise| noise.depth_at(inverse_depth))
    }

    /// Standard deviation as other cameras see it of a color channel whose value is `steps`, both 8-bit sRGB steps.
    pub(crate) fn color_noise_between(&self, steps: f32) -> f32 {
        self.noise_between.as_ref().map_or(0.0, |noise| noise.color_at(steps))
    }

    /// How much of the noise of a single frame is left in samples of a level.
    fn noise_share_of(&self, level: SpanLevel) -> f32 {
        self.noise_share.get(usize::from(level)).copied().unwrap_or(0.0)
    }

    /// Standard deviation of the color noise left in the sample at `pixel`, 8-bit sRGB steps.
    pub(crate) fn color_noise(&self, pixel: usize, steps: f32) -> f32 {
        self.color_noise_of(self.level[pixel], steps)
    }

    /// The same of samples of a level.
    pub(crate) fn color_noise_of(&self, level: SpanLevel, steps: f32) -> f32 {
        let share = self.noise_share_of(level);
        if share == 0.0 { 0.0 } else { share * self.noise.color_at(steps) }
    }
}
