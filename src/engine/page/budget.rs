//! An export within a budget, as of bytes: samples are merged where the least is lost for every one that is saved.
//!
//! The unit is the square of 2×2 tiles, which becomes one tile of half the resolution, as often as [`LEVELS`] allows. What merging it
//! loses is the squared difference between each sample's color and that of the sample it goes into, for as many frames as the image is
//! seen: even surfaces and short spans go first. Squares are merged in the order of that loss, so that a budget is met by one number:
//! how many of them are.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use crate::capture::{Intrinsics, Values};
use crate::color::steps_from_linear;
use crate::error::Result;
use crate::job::Job;
use crate::samples::{SampleImage, SampleSet, SampleTile, TILE, TileMask, halved_camera};

/// Halvings by which the largest set within a number of samples is searched for.
const COUNT_SEARCH_STEPS: usize = 12;

/// A set of at most `most` samples, to show what an export within a budget looks like: merged samples are those of further cameras, which
/// stand where the others do and have wider pixels. `None` where even the coarsest set has more. The set must have its samples in memory.
///
/// # Errors
/// `Cancelled`.
pub fn coarsened(set: &SampleSet, most: u64, job: &Job) -> Result<Option<SampleSet>> {
    if set.sample_count() <= most {
        return Ok(Some(set.clone()));
    }
    let found = Coarsening::new(set, job)?.finest(COUNT_SEARCH_STEPS, |images| {
        job.check()?;
        let count: u64 = images.iter().map(|image| image.samples.len() as u64).sum();
        Ok((count <= most).then(|| images.to_vec()))
    })?;
    let of_level = |LeveledImage { samples, level }: LeveledImage| {
        let camera = (level * set.cameras.len()) as u32 + samples.camera;
        Arc::new(SampleImage { camera, ..Arc::unwrap_or_clone(samples) })
    };
    Ok(found.map(|images| {
        let mut cameras = set.cameras.clone();
        for level in 0..LEVELS {
            let finer = &cameras[level * set.cameras.len()..];
            let coarser: Vec<_> = finer.iter().map(halved_camera).collect();
            cameras.extend(coarser);
        }
        let mut images: Vec<_> = images.into_iter().map(of_level).collect();
        images.sort_by_key(|image| (std::cmp::Reverse(image.span.len()), image.span.start, image.camera));
        SampleSet { cameras, images, ..set.clone() }
    }))
}

/// Times that samples may be merged: then one stands for 8×8.
pub(super) const LEVELS: usize = 3;

/// Samples of an image, merged `level` times.
#[derive(Clone, Debug)]
pub(crate) struct LeveledImage {
    pub(crate) samples: Arc<SampleImage>,
    pub(crate) level: usize,
}

impl LeveledImage {
    /// As the store has it.
    pub(crate) fn fine(samples: Arc<SampleImage>) -> Self {
        Self { samples, level: 0 }
    }
}

/// Row and column of a tile.
type Place = (u16, u16);

/// An image at every level, and which step merges each tile of a level: it is in the page while fewer steps are taken.
struct Pyramid {
    levels: Vec<Arc<SampleImage>>,
    merged_at: Vec<BTreeMap<Place, usize>>,
}

/// A square of tiles that may be merged.
struct Candidate {
    image: usize,
    level: usize,
    square: Place,
    loss: f64,
}

/// Every image at every level, and the order in which squares are merged.
pub(crate) struct Coarsening {
    pyramids: Vec<Pyramid>,
    steps: usize,
}

impl Coarsening {
    /// Levels of the images of a set.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(crate) fn new(set: &SampleSet, job: &Job) -> Result<Self> {
        job.start("Measuring what coarser samples lose", set.images.len());
        let prepared: Result<Vec<_>> = set
            .images
            .par_iter()
            .enumerate()
            .map(|(index, image)| {
                job.check()?;
                let intrinsics = &set.cameras[image.camera as usize].intrinsics;
                let levels = levels(image, intrinsics);
                let candidates = candidates(&levels, index);
                job.advance(1);
                Ok((Pyramid { levels, merged_at: vec![BTreeMap::new(); LEVELS] }, candidates))
            })
            .collect();
        let (mut pyramids, candidates): (Vec<_>, Vec<_>) = prepared?.into_iter().unzip();
        let mut candidates: Vec<Candidate> = candidates.into_iter().flatten().collect();
        candidates.sort_by(|a, b| a.loss.total_cmp(&b.loss));
        let steps = candidates.len();
        for (step, candidate) in candidates.into_iter().enumerate() {
            pyramids[candidate.image].merged_at[candidate.level].insert(candidate.square, step);
        }
        Ok(Self { pyramids, steps })
    }

    /// What is made of the finest images for which `made` gives something; `None` if it gives nothing even for the coarsest, which are
    /// tried first. The finest are found to within one part of 2 to the `halvings`.
    ///
    /// # Errors
    /// Those of `made`.
    pub(crate) fn finest<T>(
        &self,
        halvings: usize,
        mut made: impl FnMut(&[LeveledImage]) -> Result<Option<T>>,
    ) -> Result<Option<T>> {
        let (mut too_large, mut fits) = (0, self.steps);
        let Some(mut best) = made(&self.images(fits))? else { return Ok(None) };
        for _ in 0..halvings {
            let middle = too_large + (fits - too_large) / 2;
            if middle == too_large {
                break;
            }
            match made(&self.images(middle))? {
                Some(tried) => (fits, best) = (middle, tried),
                None => too_large = middle,
            }
        }
        Ok(Some(best))
    }

    /// The images after all squares are merged.
    pub(crate) fn coarsest(&self) -> Vec<LeveledImage> {
        self.images(self.steps)
    }

    /// The images after the first `steps` squares are merged.
    fn images(&self, steps: usize) -> Vec<LeveledImage> {
        let parts = self.pyramids.iter().flat_map(|pyramid| {
            (0..=LEVELS).map(move |level| {
                let is_merged = |level: usize, (y, x): Place| {
                    let step = pyramid.merged_at.get(level).and_then(|steps| steps.get(&(y / 2, x / 2)));
                    step.is_some_and(|step| *step < steps)
                };
                // A tile is in the page if the square that it was made of is merged, and its own square is not.
                let samples = with_tiles(&pyramid.levels[level], |tile| {
                    let place = (tile.tile_y, tile.tile_x);
                    let is_made = level == 0 || is_merged(level - 1, (2 * place.0, 2 * place.1));
                    is_made && !is_merged(level, place)
                });
                LeveledImage { samples: Arc::new(samples), level }
            })
        });
        parts.filter(|part| !part.samples.is_empty()).collect()
    }
}

/// An image and its halvings.
fn levels(image: &Arc<SampleImage>, lens: &Intrinsics) -> Vec<Arc<SampleImage>> {
    let mut levels = vec![image.clone()];
    for level in 0..LEVELS {
        let scale = f64::from(1_u32 << level);
        let half = levels[level].halved(&Intrinsics { fx: lens.fx / scale, fy: lens.fy / scale, ..*lens });
        levels.push(Arc::new(half));
    }
    levels
}

/// The squares of an image. A coarser square loses at least as much as the squares that it is made of: it comes after them.
fn candidates(levels: &[Arc<SampleImage>], image: usize) -> Vec<Candidate> {
    let mut all = Vec::new();
    let mut before: BTreeMap<Place, f64> = BTreeMap::new();
    for level in 0..LEVELS {
        let (fine, coarse) = (&levels[level], &levels[level + 1]);
        let frames = fine.span.len() as f64;
        let losses = squared_differences(fine, coarse);
        let counts = counts_by_square(fine);
        let merged: BTreeMap<Place, usize> =
            coarse.tiles.iter().map(|tile| ((tile.tile_y, tile.tile_x), tile.count())).collect();
        let mut own = BTreeMap::new();
        for (square, count) in counts {
            let saved = count.saturating_sub(merged.get(&square).copied().unwrap_or(0)).max(1);
            let loss = frames * losses.get(&square).copied().unwrap_or(0.0) / saved as f64;
            let children =
                (0..4).filter_map(|child| before.get(&(2 * square.0 + child / 2, 2 * square.1 + child % 2)));
            let loss = children.fold(loss, |loss, child| loss.max(*child)).next_up();
            own.insert(square, loss);
            all.push(Candidate { image, level, square, loss });
        }
        before = own;
    }
    all
}

fn counts_by_square(image: &SampleImage) -> BTreeMap<Place, usize> {
    let mut counts = BTreeMap::new();
    for tile in &image.tiles {
        *counts.entry((tile.tile_y / 2, tile.tile_x / 2)).or_default() += tile.count();
    }
    counts
}

/// For each square, the sum over its samples of the squared difference to the coarser sample, in 8-bit steps.
fn squared_differences(fine: &SampleImage, coarse: &SampleImage) -> BTreeMap<Place, f64> {
    let by_pixel: BTreeMap<(usize, usize), usize> =
        coarse.samples().map(|sample| ((sample.y, sample.x), sample.index)).collect();
    let mut sums: BTreeMap<Place, f64> = BTreeMap::new();
    for sample in fine.samples() {
        let Some(&merged) = by_pixel.get(&(sample.y / 2, sample.x / 2)) else { continue };
        let (own, other) = (fine.color[sample.index], coarse.color[merged]);
        let square = (0..3)
            .map(|channel| f64::from(steps_from_linear(own[channel]) - steps_from_linear(other[channel])))
            .map(|step| step * step)
            .sum::<f64>();
        let side = 2 * TILE;
        *sums.entry(((sample.y / side) as u16, (sample.x / side) as u16)).or_default() += square;
    }
    sums
}

/// An image of some of the tiles of another.
fn with_tiles(image: &SampleImage, is_wanted: impl Fn(&SampleTile) -> bool) -> SampleImage {
    let mut part = image.without_samples();
    (part.normal, part.values) = (None, Values::default());
    for (index, tile) in image.tiles.iter().enumerate().filter(|(_, tile)| is_wanted(tile)) {
        if let Some(rows) = image.doubtful_rows(index) {
            part.doubtful.push(TileMask { tile: part.tiles.len() as u32, rows: *rows });
        }
        let samples = tile.first as usize..tile.first as usize + tile.count();
        part.tiles.push(SampleTile { first: part.color.len() as u32, ..*tile });
        part.depth.push_packed(&image.depth.tile(index, tile.first, tile.count()));
        part.color.extend_from_slice(&image.color[samples]);
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::preprocess;
    use crate::render::{CpuRenderer, Vantage};
    use crate::settings::Settings;

    #[test]
    fn merged_squares_replace_their_samples_level_by_level_until_the_coarsest_is_left() {
        let demo = Demo::new(&DemoSpec::new("orrery").size((96, 72)).frames(2)).unwrap();
        let settings = Settings::default();
        let set = preprocess(&demo.capture(&settings.capture), &settings, &Job::new()).unwrap().samples;
        let coarsening = Coarsening::new(&set, &Job::new()).unwrap();
        let count = |steps: usize| {
            coarsening.images(steps).iter().map(|image| image.samples.len() as u64).sum::<u64>()
        };
        assert_eq!(count(0), set.sample_count());
        let steps = coarsening.steps;
        let counts: Vec<u64> = (0..=8).map(|eighth| count(steps * eighth / 8)).collect();
        assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
        assert!(counts[8] * 20 < counts[0], "{counts:?}");
        assert!(coarsening.images(steps).iter().all(|image| image.level == LEVELS));
    }
    #[test]
    fn a_set_within_a_number_of_samples_looks_like_the_whole_and_the_more_so_the_more_it_may_hold() {
        let demo = Demo::new(&DemoSpec::new("orrery").size((96, 72)).frames(1)).unwrap();
        let settings = Settings::default();
        let set = preprocess(&demo.capture(&settings.capture), &settings, &Job::new()).unwrap().samples;
        let vantage = Vantage { camera: set.cameras[0].clone(), frame: 0 };
        let picture = |set: &SampleSet| {
            let painted =
                CpuRenderer::new().render(&Arc::new(set.clone()), &vantage, &settings.render, &Job::new());
            painted.unwrap().0.color.clone()
        };
        let whole = picture(&set);
        let error = |share: u64| {
            let most = set.sample_count() / share;
            let some = coarsened(&set, most, &Job::new()).unwrap().unwrap();
            assert!(some.sample_count() <= most && some.sample_count() * 3 > most, "{share}");
            let other = picture(&some);
            let pairs = whole.as_slice().iter().zip(other.as_slice());
            let squares =
                pairs.flat_map(|(a, b)| (0..3).map(move |part| f64::from(a[part] - b[part]).powi(2)));
            squares.sum::<f64>() / (3 * whole.as_slice().len()) as f64
        };
        let [half, tenth] = [error(2), error(10)];
        assert!(half < tenth && half < 0.005 && tenth < 0.02, "{half} {tenth}");
        assert!(coarsened(&set, 1, &Job::new()).unwrap().is_none());
    }
}
