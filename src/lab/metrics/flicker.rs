//! Temporal flicker at a still vantage: by how much the error of a pixel changes from one frame to the next.
//!
//! A constant error is less visible than one that comes and goes. The measure is the root mean square over pixels and pairs of
//! frames of `(picture − truth)(t₂) − (picture − truth)(t₁)`, in 8-bit steps: true motion cancels, and a constant error scores 0.
//! Noise in the truth counts too, alike for every method.

use serde::{Deserialize, Serialize};

use super::pair::Pair;
use overlook_engine::capture::Camera;

/// The change of error between two views, or several: squares summed over pixels and channels, and their number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlickerSum {
    squares: f64,
    count: u64,
}

impl FlickerSum {
    fn add(&mut self, other: Self) {
        self.squares += other.squares;
        self.count += other.count;
    }
}

/// Sums up the change of error over consecutive views of one vantage.
#[derive(Clone, Debug, Default)]
pub(crate) struct FlickerMeter {
    previous: Option<(Camera, Vec<Option<[f32; 3]>>)>,
    all: FlickerSum,
}

impl FlickerMeter {
    /// Adds the next view, and gives its change from the one before. Views of one vantage must follow each other, in the order of
    /// their frames.
    pub(crate) fn add(&mut self, camera: &Camera, compared: &Pair) -> FlickerSum {
        let change = self.change_to(camera, compared);
        self.all.add(change);
        change
    }

    /// Adds a change that was measured elsewhere.
    pub(crate) fn add_known(&mut self, change: FlickerSum) {
        self.all.add(change);
    }

    /// The change from the view before to this one, which becomes the one before.
    pub(crate) fn change_to(&mut self, camera: &Camera, compared: &Pair) -> FlickerSum {
        let errors = compared.errors();
        let mut sum = FlickerSum::default();
        if let Some((_, before)) = self.previous.as_ref().filter(|(previous, _)| previous == camera) {
            for (before, after) in before.iter().zip(&errors) {
                let (Some(before), Some(after)) = (before, after) else { continue };
                for channel in 0..3 {
                    let change = f64::from(after[channel] - before[channel]);
                    sum.squares += change * change;
                }
                sum.count += 3;
            }
        }
        self.previous = Some((camera.clone(), errors));
        sum
    }

    /// Root mean square change of error, 8-bit steps; `None` where no vantage was seen at two frames.
    pub(crate) fn steps(&self) -> Option<f64> {
        let FlickerSum { squares, count } = self.all;
        (count > 0).then(|| 255.0 * (squares / count as f64).sqrt())
    }
}
