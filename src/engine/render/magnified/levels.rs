//! Which level each pixel of a close-up shows.

use rayon::prelude::*;

use crate::capture::{Camera, Intrinsics};
use crate::grid::Grid;
use crate::render::geometry::Projector;
use crate::render::recorded_rates::RecordedRates;
use crate::render::vantage::{Picture, Vantage};
use crate::samples::SampleSet;
use crate::settings::{Magnified, RenderSettings};

/// From this magnification on a coarser level has a part.
const LEAST_MAGNIFICATION: f32 = 2.5;

/// Coarsest level: a sixteenth of the columns and rows.
pub(crate) const COARSEST: usize = 4;

/// A level serves if at least this share of the picture asks for it.
const LEAST_SHARE: f64 = 0.1;

/// The coarsest level that a picture shows a part of; 0 if it shows nothing but itself.
pub(crate) fn coarsest_level(rates: &RecordedRates, settings: &RenderSettings) -> usize {
    let applies = settings.magnified == Magnified::Upsampled && settings.kernel.interpolates();
    let rate = if applies { rates.of_share(1.0 - LEAST_SHARE) } else { 0.0 };
    if rate > 0.0 { (level_of(rate.recip()).ceil() as usize).min(COARSEST) } else { 0 }
}

/// The level that a pixel of a magnification shows, fractions between two; not more than [`COARSEST`].
fn level_of(magnification: f32) -> f32 {
    (magnification / LEAST_MAGNIFICATION).log2().clamp(0.0, COARSEST as f32)
}

/// The view with `1 / 2^level` of its columns and rows, rounded up.
pub(super) fn coarser(vantage: &Vantage, level: usize) -> Vantage {
    let mut coarser = vantage.clone();
    let Intrinsics { width, height, fx, fy, cx, cy, .. } = &mut coarser.camera.intrinsics;
    for side in [width, height] {
        *side = side.div_ceil(1 << level);
    }
    for length in [fx, fy, cx, cy] {
        *length /= f64::from(1_u32 << level);
    }
    coarser
}

/// Which level each pixel shows.
pub(super) struct LevelMap {
    /// As fine as the coarsest level.
    pub(super) levels: Grid<f32>,
    pub(super) coarsest: usize,
    /// The finest level that anything shows.
    pub(super) finest: usize,
}

impl LevelMap {
    /// By the coarsest level of a view: around everything that it shows magnified, its silhouette is that of this level too.
    pub(super) fn new(coarsest: &Picture, level: usize, samples: &SampleSet, view: &Vantage) -> Self {
        let (width, height) = coarsest.image.size();
        let recorded = RecordedPixels::new(samples, &coarser(view, level).camera);
        let own = |pixel: usize| {
            let image = *coarsest.image.as_slice().get(pixel)?;
            let place = ((pixel % width) as f32, (pixel / width) as f32);
            let width =
                recorded.along_pixel(image, place, coarsest.inverse_depth.as_slice()[pixel].max(0.0))?;
            Some(level_of((1 << level) as f32 / width).min(level as f32))
        };
        let own: Vec<Option<f32>> = (0..width * height).into_par_iter().map(&own).collect();
        let around = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let levels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
            // Where nothing but holes is around, they are filled smoothly, at any level.
            levels.filter_map(|(x, y)| own[y * width + x]).reduce(f32::max).unwrap_or(level as f32)
        };
        let levels: Vec<f32> = (0..width * height).into_par_iter().map(&around).collect();
        let mut map = Self { levels: Grid::from_vec(width, height, levels), coarsest: level, finest: 0 };
        map.leave_out_rare_levels();
        map
    }

    /// Leaves out the finest levels as long as hardly anything shows them.
    fn leave_out_rare_levels(&mut self) {
        let least = LEAST_SHARE * self.levels.len() as f64;
        let levels = self.levels.as_mut_slice();
        while self.finest < self.coarsest {
            let finest = self.finest as f32;
            let shown: f64 = levels.iter().map(|level| f64::from((finest + 1.0 - level).max(0.0))).sum();
            if shown >= least {
                return;
            }
            self.finest += 1;
            for level in levels.iter_mut() {
                *level = level.max(finest + 1.0);
            }
        }
    }

    /// Whether anything shows a level: levels are interpolated, so that all between the finest and the coarsest are shown somewhere.
    pub(super) fn shows(&self, level: usize) -> bool {
        let levels = self.levels.as_slice().iter().copied();
        let [finest, coarsest] = [levels.clone().reduce(f32::min), levels.reduce(f32::max)];
        let level = level as f32;
        finest.is_some_and(|finest| level > finest - 1.0)
            && coarsest.is_some_and(|coarsest| level < coarsest + 1.0)
    }
}

/// How finely surfaces were recorded that a view shows.
struct RecordedPixels<'a> {
    samples: &'a SampleSet,
    source_from_target: Vec<Projector>,
    /// Whether each surface is shown by the camera that saw it best, as after pruning.
    is_pruned: bool,
}

impl<'a> RecordedPixels<'a> {
    fn new(samples: &'a SampleSet, target: &Camera) -> Self {
        let of_camera = |source: &Camera| Projector::new(target, source);
        Self {
            samples,
            source_from_target: samples.cameras.iter().map(of_camera).collect(),
            is_pruned: samples.is_pruned(),
        }
    }

    /// Recorded pixels along a pixel of the view that shows a sample of an image at inverse depth `w`; of all cameras that look there,
    /// those of the nearest, where any of them may have the surface. `None` in holes.
    fn along_pixel(&self, image: u32, (x, y): (f32, f32), w: f32) -> Option<f32> {
        let own = self.samples.images.get(image as usize)?.camera as usize;
        let of_camera = |camera: usize| {
            let projector = self.source_from_target.get(camera)?;
            let point = projector.point(x, y, w);
            let (width, height) = self.samples.cameras[camera].intrinsics.size();
            let [u, v] = projector.position(point, w);
            let looks_there = (0.0..width as f32).contains(&u) && (0.0..height as f32).contains(&v);
            (point.z > 0.0 && (looks_there || camera == own)).then(|| {
                if projector.target_is_orthographic {
                    projector.magnification(w, point.z.recip())
                } else {
                    projector.focal_ratio / point.z
                }
            })
        };
        if self.is_pruned {
            return of_camera(own);
        }
        (0..self.source_from_target.len()).filter_map(of_camera).reduce(f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_that_hardly_anything_shows_are_left_out() {
        let map = |levels: Vec<f32>| {
            let mut map = LevelMap { levels: Grid::from_vec(10, 10, levels), coarsest: 3, finest: 0 };
            map.leave_out_rare_levels();
            map
        };
        let mut levels = vec![2.5; 100];
        levels[0] = 0.0;
        let rare = map(levels.clone());
        assert_eq!((rare.finest, rare.shows(1), rare.shows(2), rare.shows(3)), (2, false, true, true));
        levels[1..10].fill(0.0);
        let shown = map(levels);
        assert_eq!((shown.finest, shown.shows(0)), (0, true));
    }

    #[test]
    fn levels_between_those_of_neighbors_are_shown() {
        let map =
            |levels: Vec<f32>| LevelMap { levels: Grid::from_vec(2, 1, levels), coarsest: 4, finest: 0 };
        let shown = |levels: Vec<f32>| -> Vec<usize> {
            (0..5).filter(|level| map(levels.clone()).shows(*level)).collect()
        };
        assert_eq!(shown(vec![0.0, 3.0]), [0, 1, 2, 3]);
        assert_eq!(shown(vec![1.5, 1.5]), [1, 2]);
        assert_eq!(shown(vec![4.0, 4.0]), [4]);
    }
}
