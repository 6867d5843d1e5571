//! One camera at one frame, ready to be registered: every pixel's sample with its normal, footprint and facet.

use std::sync::Arc;

use glam::Vec3;
use half::f16;

use super::packed_sample::{ABSENT_RANK, PackedColor, PackedGeometry, Rank};
use crate::capture::{Frame, INVALID_INVERSE_DEPTH};
use crate::preprocess::noise::{CameraNoise, NoiseBetween};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel, SpanSamples};

/// The samples of one camera, row-major planes of the camera's size.
#[derive(Clone, Debug)]
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
        Self {
            width,
            color: vec![[f16::ZERO; 3]; pixels],
            inverse_depth: vec![INVALID_INVERSE_DEPTH; pixels],
            normal: vec![Vec3::ZERO; pixels],
            footprint: vec![f32::INFINITY; pixels],
            ranks: vec![ABSENT_RANK; pixels],
            geometry: vec![PackedGeometry::ABSENT; pixels],
            packed_colors: vec![PackedColor::ABSENT; pixels],
            level: vec![NO_SAMPLE; pixels],
            noise: CameraNoise::default(),
            noise_share: Vec::new(),
            depth_step_relative: 0.0,
            noise_between: None,
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
            pixels.push(pixel as u32);
        }
        pixels
    }

    /// Takes the sample at `pixel` away.
    pub(crate) fn clear(&mut self, pixel: usize) {
        self.color[pixel] = [f16::ZERO; 3];
        self.inverse_depth[pixel] = INVALID_INVERSE_DEPTH;
        self.normal[pixel] = Vec3::ZERO;
        self.footprint[pixel] = f32::INFINITY;
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
        self.noise_share_at(pixel) * self.noise.depth_relative
    }

    /// Relative standard deviation of the depth of the sample at `pixel` as other cameras see it.
    pub(crate) fn depth_noise_between(&self, pixel: usize) -> f32 {
        self.noise_between.as_ref().map_or(0.0, |noise| noise.depth_at(self.inverse_depth[pixel]))
    }

    /// Standard deviation as other cameras see it of a color channel whose value is `steps`, both 8-bit sRGB steps.
    pub(crate) fn color_noise_between(&self, steps: f32) -> f32 {
        self.noise_between.as_ref().map_or(0.0, |noise| noise.color_at(steps))
    }

    /// How much of the noise of a single frame is left in the sample at `pixel`.
    fn noise_share_at(&self, pixel: usize) -> f32 {
        self.noise_share.get(usize::from(self.level[pixel])).copied().unwrap_or(0.0)
    }

    /// Standard deviation of the color noise left in the sample at `pixel`, 8-bit sRGB steps.
    pub(crate) fn color_noise(&self, pixel: usize, steps: f32) -> f32 {
        let share = self.noise_share_at(pixel);
        if share == 0.0 { 0.0 } else { share * self.noise.color_at(steps) }
    }
}
