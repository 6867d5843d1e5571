//! Temporal flicker at a still vantage: by how much the error of a pixel changes from one frame to the next.
//!
//! A constant error is less visible than one that comes and goes. The measure is the root mean square over pixels and pairs of
//! frames of `(picture − truth)(t₂) − (picture − truth)(t₁)`, in 8-bit steps: true motion cancels, and a constant error scores 0.
//! Noise in the truth counts too, alike for every method.

use super::pair::Pair;
use overlook_engine::capture::Camera;

/// Sums up the change of error over consecutive views of one vantage.
#[derive(Clone, Debug, Default)]
pub(crate) struct FlickerMeter {
    previous: Option<(Camera, Vec<Option<[f32; 3]>>)>,
    squares: f64,
    count: u64,
}

impl FlickerMeter {
    /// Adds the next view. Views of one vantage must follow each other, in the order of their frames.
    pub(crate) fn add(&mut self, camera: &Camera, compared: &Pair) {
        let errors = compared.errors();
        let mut squares = 0.0;
        if let Some((_, before)) = self.previous.as_ref().filter(|(previous, _)| previous == camera) {
            for (before, after) in before.iter().zip(&errors) {
                let (Some(before), Some(after)) = (before, after) else { continue };
                for channel in 0..3 {
                    let change = f64::from(after[channel] - before[channel]);
                    squares += change * change;
                }
                self.count += 3;
            }
        }
        self.squares += squares;
        self.previous = Some((camera.clone(), errors));
    }

    /// Root mean square change of error, 8-bit steps; `None` where no vantage was seen at two frames.
    pub(crate) fn steps(&self) -> Option<f64> {
        (self.count > 0).then(|| 255.0 * (self.squares / self.count as f64).sqrt())
    }
}
