//! What a camera saw, as a few boxes: enough to prove that another camera cannot see any of it.

use super::registration::Registration;
use crate::capture::camera::Camera;

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
