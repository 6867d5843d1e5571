//! Close-ups: parts of a picture that are finer than any camera recorded are rendered coarser, and upsampled.
//!
//! Purpose: where a recorded pixel covers many pixels of the picture, gaps between samples and steps along silhouettes are as wide as
//! a recorded pixel, and cameras do not show which side of them a pixel is on. With a few pixels to a sample there are neither.
//!
//! Levels are pictures of the same view with half, a quarter, … of its columns and rows. A pixel that is magnified by the factor `m`
//! shows level `log₂(m / 2.5)`, between two levels a blend of both: below, a coarser level would lose detail.
//!
//! Source: the blend between levels is that of Lance Williams, *Pyramidal Parametrics*, SIGGRAPH 1983. What differs: it goes the other
//! way, from pictures that are too coarse to one that is fine enough.

mod levels;
mod upsample;

pub(super) use levels::{COARSEST, coarsest_level};

use std::sync::Arc;
use std::time::Instant;

use super::vantage::{Picture, RenderStats, Vantage};
use crate::error::Result;
use crate::samples::SampleSet;
use levels::{LevelMap, coarser};
use upsample::blended;

/// A view out of its levels up to the coarsest, which `paint` paints.
///
/// # Errors
/// As [`Vantage::check`] and `paint`.
pub(super) fn by_levels(
    coarsest: usize,
    samples: &SampleSet,
    view: &Vantage,
    mut paint: impl FnMut(usize, &Vantage) -> Result<(Arc<Picture>, RenderStats)>,
) -> Result<(Arc<Picture>, RenderStats)> {
    let started = Instant::now();
    view.check(samples)?;
    let (picture, mut stats) = paint(coarsest, &coarser(view, coarsest))?;
    let map = LevelMap::new(&picture, coarsest, samples, view);
    let mut levels = vec![(coarsest, picture)];
    for level in (map.finest..coarsest).rev().filter(|level| map.shows(*level)) {
        let (picture, more) = paint(level, &coarser(view, level))?;
        // Every level projects the same samples, or fewer of them.
        stats.samples = stats.samples.max(more.samples);
        stats.stages.add(&more.stages);
        stats.background_reused &= more.background_reused;
        levels.push((level, picture));
    }
    let picture = blended(&levels, &map, view.camera.intrinsics.size());
    stats.holes = picture.holes();
    stats.milliseconds = started.elapsed().as_secs_f64() * 1e3;
    Ok((Arc::new(picture), stats))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::job::Job;
    use crate::render::supersample::finer;
    use crate::render::tests::scene;
    use crate::render::{CpuRenderer, NO_IMAGE, Renderer};
    use crate::settings::{Backend, Fill, Magnified, RenderSettings};

    fn settings(magnified: Magnified) -> RenderSettings {
        RenderSettings { magnified, backend: Backend::Cpu, ..RenderSettings::default() }
    }

    fn render(samples: &Arc<SampleSet>, view: &Vantage, settings: &RenderSettings) -> Arc<Picture> {
        Renderer::new().render(samples, view, settings, &Job::new()).unwrap().0
    }

    /// Samples, and their view with this many times the columns and rows.
    fn magnified(times: usize) -> (Arc<SampleSet>, Vantage) {
        let (samples, view) = scene(DemoSpec::new("orrery").cameras(3).size((64, 48)), 0);
        let camera = finer(&view.camera, times);
        (samples, Vantage { camera, ..view })
    }

    #[test]
    fn pictures_that_magnify_nothing_are_the_same_bits_with_and_without_levels() {
        let (samples, view) = magnified(1);
        let plain = CpuRenderer::new()
            .render(&samples, &view, &settings(Magnified::Upsampled), &Job::new())
            .unwrap()
            .0;
        assert_eq!(*render(&samples, &view, &settings(Magnified::Upsampled)), *plain);
        assert_eq!(*render(&samples, &view, &settings(Magnified::Direct)), *plain);
    }

    #[test]
    fn a_close_up_shows_the_same_surfaces_with_and_without_levels() {
        let (samples, view) = magnified(6);
        let [upsampled, direct] =
            [Magnified::Upsampled, Magnified::Direct].map(|way| render(&samples, &view, &settings(way)));
        assert_eq!(upsampled.color.size(), direct.color.size());
        let mut same = 0;
        let pixels = upsampled.inverse_depth.as_slice().iter().zip(direct.inverse_depth.as_slice());
        for (ours, theirs) in pixels {
            assert!(*ours >= 0.0, "everything is filled");
            same += usize::from((ours - theirs).abs() <= 0.02 * theirs.abs());
        }
        assert!(same * 10 > direct.image.len() * 9, "{same} of {}", direct.image.len());
    }

    #[test]
    fn holes_that_are_not_filled_stay_holes() {
        let (samples, view) = magnified(6);
        let unfilled =
            RenderSettings { fill: Fill::None, free_space: false, ..settings(Magnified::Upsampled) };
        let picture = render(&samples, &view, &unfilled);
        assert!(
            picture.holes() > 0 && picture.holes() < picture.image.len() as u64 / 4,
            "{}",
            picture.holes()
        );
        for (pixel, image) in picture.image.as_slice().iter().enumerate() {
            let is_empty = picture.inverse_depth.as_slice()[pixel] < 0.0;
            assert_eq!(*image == NO_IMAGE, is_empty);
            assert!(!is_empty || picture.color.as_slice()[pixel] == [0.0; 3]);
        }
    }
}
