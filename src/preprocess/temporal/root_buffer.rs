//! The samples of the span of all frames. Most pixels of most pictures have one, so that all bands write into one buffer with
//! room for every pixel, and the gaps are closed at the end.

use glam::Vec3;
use half::f16;

use super::pixel_stats::SpanSums;
use super::span_means::{mean_normal, write_means};
use super::span_store::SpanSamples;

/// Room for a sample in each pixel of a picture.
pub(crate) struct RootSamples(SpanSamples);

/// The room of some pixels that follow one another, of which the first `count` entries are taken.
pub(crate) struct RootBand<'a> {
    pixels: &'a mut [u32],
    color: &'a mut [[f16; 3]],
    inverse_depth: &'a mut [f32],
    /// Empty where the capture gives none.
    normal: &'a mut [Vec3],
    count: usize,
}

impl RootSamples {
    /// For so many pixels, with or without given normals.
    pub(crate) fn of(pixels: usize, normals: bool) -> Self {
        Self(SpanSamples {
            pixels: bytemuck::zeroed_vec(pixels),
            color: bytemuck::zeroed_vec(pixels),
            inverse_depth: bytemuck::zeroed_vec(pixels),
            normal: bytemuck::zeroed_vec(if normals { pixels } else { 0 }),
        })
    }

    /// Cut into bands of so many pixels.
    pub(crate) fn bands(&mut self, pixels: usize) -> Vec<RootBand<'_>> {
        let SpanSamples { pixels: numbers, color, inverse_depth, normal } = &mut self.0;
        let mut normals = normal.chunks_mut(pixels);
        let planes =
            numbers.chunks_mut(pixels).zip(color.chunks_mut(pixels)).zip(inverse_depth.chunks_mut(pixels));
        let bands = planes.map(|((pixels, color), inverse_depth)| {
            let normal = normals.next().unwrap_or_default();
            RootBand { pixels, color, inverse_depth, normal, count: 0 }
        });
        bands.collect()
    }

    /// The samples of all bands of so many pixels, which have these counts.
    pub(crate) fn joined(self, counts: &[usize], pixels: usize) -> SpanSamples {
        let SpanSamples { pixels: mut numbers, mut color, mut inverse_depth, mut normal } = self.0;
        close_gaps(&mut numbers, counts, pixels);
        close_gaps(&mut color, counts, pixels);
        close_gaps(&mut inverse_depth, counts, pixels);
        if !normal.is_empty() {
            close_gaps(&mut normal, counts, pixels);
        }
        SpanSamples { pixels: numbers, color, inverse_depth, normal }
    }
}

/// Moves the first entries of each chunk, so many as `counts` says, up to those of the chunk before.
fn close_gaps<T: Copy>(plane: &mut Vec<T>, counts: &[usize], chunk: usize) {
    let mut end = 0;
    for (nth, &count) in counts.iter().enumerate() {
        let start = nth * chunk;
        if start != end {
            plane.copy_within(start..start + count, end);
        }
        end += count;
    }
    plane.truncate(end);
    plane.shrink_to_fit();
}

impl RootBand<'_> {
    /// Samples.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Writes the samples of all pixels that `sums` has, the first of which is `first`. It is for [`RootBand::take`] to say which of
    /// them stay.
    pub(crate) fn write(&mut self, first: usize, sums: &SpanSums) {
        let at = self.count..self.count + sums.pixels();
        for (pixel, number) in self.pixels[at.clone()].iter_mut().zip(first as u32..) {
            *pixel = number;
        }
        write_means(sums, &mut self.color[at.clone()], &mut self.inverse_depth[at.clone()]);
        for (pixel, normal) in self.normal.iter_mut().skip(at.start).take(at.len()).enumerate() {
            *normal = mean_normal(sums, pixel).unwrap_or_default();
        }
    }

    /// Keeps those samples of the pixels of `sums`, written last, that are open.
    pub(crate) fn take(&mut self, sums: &SpanSums) {
        if sums.is_all_open() {
            self.count += sums.pixels();
            return;
        }
        let first = self.count;
        for from in (0..sums.pixels()).filter(|pixel| sums.is_open(*pixel)).map(|pixel| first + pixel) {
            let to = self.count;
            self.pixels[to] = self.pixels[from];
            self.color[to] = self.color[from];
            self.inverse_depth[to] = self.inverse_depth[from];
            if let Some(normal) = self.normal.get(from).copied() {
                self.normal[to] = normal;
            }
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preprocess::temporal::pixel_stats::FrameRun;

    #[test]
    fn exactly_the_open_pixels_of_all_bands_are_joined_in_order() {
        const PIXELS: usize = 100;
        const BAND: usize = 30;
        const CHUNK: usize = 12;
        let color: Vec<i16> = (0..3 * PIXELS as i16).map(|i| 0x3800 + i).collect();
        let inverse_depth: Vec<f32> = (0..PIXELS).map(|i| 1.0 / (1 + i) as f32).collect();
        let normal: Vec<f32> = (0..PIXELS).flat_map(|i| (Vec3::new(1.0, i as f32, 2.0)).to_array()).collect();
        for normal in [&[], normal.as_slice()] {
            let mut root = RootSamples::of(PIXELS, !normal.is_empty());
            let is_closed = |pixel: usize| (25..40).contains(&pixel) || pixel.is_multiple_of(13);
            let mut bands = root.bands(BAND);
            for (nth, band) in bands.iter_mut().enumerate() {
                let end = PIXELS.min((nth + 1) * BAND);
                for first in (nth * BAND..end).step_by(CHUNK) {
                    let run = FrameRun {
                        color: &color[3 * first..],
                        inverse_depth: &inverse_depth[first..],
                        normal: normal.get(3 * first..).unwrap_or_default(),
                    };
                    let mut sums = SpanSums::of(&[run], CHUNK.min(end - first));
                    (0..sums.pixels())
                        .filter(|pixel| is_closed(first + pixel))
                        .for_each(|pixel| sums.close(pixel));
                    band.write(first, &sums);
                    band.take(&sums);
                }
            }
            let counts: Vec<usize> = bands.iter().map(RootBand::count).collect();
            let joined = root.joined(&counts, BAND);
            let open: Vec<u32> = (0..PIXELS as u32).filter(|pixel| !is_closed(*pixel as usize)).collect();
            assert_eq!(joined.pixels, open);
            for (nth, pixel) in open.iter().map(|pixel| *pixel as usize).enumerate() {
                let bits = joined.color[nth].map(|half| half.to_bits() as i16);
                assert_eq!(bits, color[3 * pixel..3 * pixel + 3]);
                assert_eq!(joined.inverse_depth[nth], inverse_depth[pixel]);
                if !normal.is_empty() {
                    assert_eq!(
                        joined.normal[nth],
                        Vec3::from_slice(&normal[3 * pixel..]).normalize_or_zero()
                    );
                }
            }
            assert_eq!(joined.normal.len(), if normal.is_empty() { 0 } else { open.len() });
        }
    }
}
