//! All views, and which of them may see the same.

use rayon::prelude::*;

use super::groups::Neighbors;
use super::registration::Registration;
use crate::capture::camera::Camera;
use crate::median::median;

/// All views, and for each those that may see any of its samples, with the way there.
pub struct OverlapGraph<'a> {
    cameras: &'a [Camera],
    of_view: Vec<OthersOf>,
    /// How far away things are; 0 where that is not known.
    typical_depth: f64,
}

/// One view, and those that may see any of its samples.
struct OthersOf {
    itself: Registration,
    /// Ascending.
    others: Vec<u32>,
    /// One for each of `others`.
    registrations: Vec<Registration>,
}

impl<'a> OverlapGraph<'a> {
    /// Every view of `cameras` may see what any other one saw.
    #[must_use]
    pub fn complete(cameras: &'a [Camera]) -> Self {
        Self::where_seen(cameras, 0.0, |_, _| true)
    }

    /// The pairs whose target may see what the source saw. No sample of any other source is in the picture of its target.
    ///
    /// A target that saw only nearer surfaces is not left out: the distance from a tangent plane decides whether both saw the same
    /// surface, and a surface seen from its edge is close to that plane at any depth.
    pub(crate) fn of_depths(cameras: &'a [Camera], bounds: &[DepthBounds]) -> Self {
        let mut depths: Vec<f64> = bounds.iter().filter_map(DepthBounds::middle_depth).collect();
        let is_seen = |source: usize, way: &Registration| bounds[source].may_be_seen_through(way);
        Self::where_seen(cameras, median(&mut depths).unwrap_or(0.0), is_seen)
    }

    fn where_seen(
        cameras: &'a [Camera],
        typical_depth: f64,
        is_seen: impl Fn(usize, &Registration) -> bool + Sync,
    ) -> Self {
        let of_view = |(source, camera): (usize, &Camera)| {
            let others = cameras.iter().enumerate().filter(|(target, _)| *target != source);
            let registered = others.map(|(target, other)| (target as u32, Registration::new(camera, other)));
            let (others, registrations) =
                registered.filter(|(_, registration)| is_seen(source, registration)).unzip();
            OthersOf { itself: Registration::new(camera, camera), others, registrations }
        };
        Self { cameras, of_view: cameras.par_iter().enumerate().map(of_view).collect(), typical_depth }
    }

    /// From view `source` to view `target`, which is the same or one of [`OverlapGraph::others`].
    pub(crate) fn registration(&self, source: usize, target: usize) -> &Registration {
        let of_source = &self.of_view[source];
        if let Ok(at) = of_source.others.binary_search(&(target as u32)) {
            return &of_source.registrations[at];
        }
        debug_assert_eq!(source, target, "views that do not see each other are not compared");
        &of_source.itself
    }

    /// The views that may see any sample of `source`, ascending, each with the way there.
    #[inline(always)]
    pub(crate) fn others(&self, source: usize) -> impl ExactSizeIterator<Item = (usize, &Registration)> {
        let OthersOf { others, registrations, .. } = &self.of_view[source];
        others.iter().map(|other| *other as usize).zip(registrations)
    }

    /// Those of [`OverlapGraph::others`] that are among some views, ascending.
    #[inline(always)]
    pub(crate) fn others_among(
        &self,
        source: usize,
        views: &[usize],
    ) -> impl Iterator<Item = (usize, &Registration)> {
        let OthersOf { others, registrations, .. } = &self.of_view[source];
        let at = |view: &usize| others.binary_search(&(*view as u32)).ok();
        views.iter().filter_map(move |view| at(view).map(|at| (*view, &registrations[at])))
    }

    /// Some of [`OverlapGraph::others`], spread over them: `count` at most. They are counted from the view itself, so that no view is
    /// one of the few of all.
    pub(crate) fn few_others(&self, source: usize, count: usize) -> impl Iterator<Item = usize> {
        let others = &self.of_view[source].others;
        let following = others.partition_point(|other| (*other as usize) < source);
        let step = others.len().div_ceil(count).max(1);
        let from_source = others[following..].iter().chain(&others[..following]);
        from_source.step_by(step).map(|other| *other as usize)
    }

    /// All views in groups of neighbors, see [`Neighbors::groups`].
    pub(crate) fn groups(&self, take: impl FnMut(&[usize]) -> usize) -> Vec<Vec<usize>> {
        Neighbors::new(self.cameras, self.typical_depth).groups(take)
    }

    /// The cameras.
    pub(crate) fn cameras(&self) -> &'a [Camera] {
        self.cameras
    }
}

/// Columns and rows of a block of pixels whose depths are known together.
const BLOCK: usize = 64;

/// The smallest and largest inverse depths of a camera's samples, block by block.
#[derive(Clone, Debug)]
pub struct DepthBounds {
    width: usize,
    height: usize,
    /// Bounds of all samples.
    whole: [f32; 2],
    /// Row by row; the smallest is larger where there is no sample.
    blocks: Vec<[f32; 2]>,
}

const NOTHING: [f32; 2] = [f32::INFINITY, 0.0];

/// The smallest and largest inverse depth of several blocks.
fn union(blocks: &[[f32; 2]]) -> [f32; 2] {
    blocks.iter().fold(NOTHING, |all, block| [all[0].min(block[0]), all[1].max(block[1])])
}

impl DepthBounds {
    /// What a camera with this width and height saw: inverse depths by pixel, `y * width + x`.
    #[must_use]
    pub fn new((width, height): (usize, usize), samples: impl Iterator<Item = (u32, f32)>) -> Self {
        let across = width.div_ceil(BLOCK);
        let mut blocks = vec![NOTHING; across * height.div_ceil(BLOCK)];
        for (pixel, inverse_depth) in samples {
            let (x, y) = (pixel as usize % width, pixel as usize / width);
            let [smallest, largest] = &mut blocks[y / BLOCK * across + x / BLOCK];
            *smallest = smallest.min(inverse_depth);
            *largest = largest.max(inverse_depth);
        }
        Self { width, height, whole: union(&blocks), blocks }
    }

    /// These bounds if each depth may be off by a share of it, less than 1.
    pub(crate) fn blurred(&self, share: f32) -> Self {
        let blur = |[smallest, largest]: [f32; 2]| [smallest / (1.0 + share), largest / (1.0 - share)];
        let is_any = |block: &[f32; 2]| block[0] <= block[1];
        let blurred = self.blocks.iter().map(|block| if is_any(block) { blur(*block) } else { NOTHING });
        let blocks: Vec<[f32; 2]> = blurred.collect();
        Self { whole: union(&blocks), blocks, ..*self }
    }

    /// Whether `target` may see any of the samples of `source`. It may wrongly be true, never wrongly false.
    #[must_use]
    pub fn may_be_seen(&self, source: &Camera, target: &Camera) -> bool {
        self.may_be_seen_through(&Registration::new(source, target))
    }

    /// The same for the target of a registration.
    pub(super) fn may_be_seen_through(&self, registration: &Registration) -> bool {
        let (columns, rows) = ([0, self.width - 1], [0, self.height - 1]);
        if self.whole[0] > self.whole[1] || !registration.may_see(columns, rows, self.whole) {
            return false;
        }
        let across = self.width.div_ceil(BLOCK);
        self.blocks.iter().enumerate().filter(|(_, block)| block[0] <= block[1]).any(|(at, block)| {
            let last = |first: usize, size: usize| (first + BLOCK).min(size) - 1;
            let [left, top] = [at % across * BLOCK, at / across * BLOCK];
            registration.may_see([left, last(left, self.width)], [top, last(top, self.height)], *block)
        })
    }

    /// The depth in the middle of all samples, by inverse depth; `None` without any.
    pub(super) fn middle_depth(&self) -> Option<f64> {
        let [smallest, largest] = self.whole.map(f64::from);
        (smallest <= largest && largest > 0.0).then(|| 2.0 / (smallest + largest))
    }
}
