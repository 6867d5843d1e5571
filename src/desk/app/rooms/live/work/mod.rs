//! How the live view is painted: at once and as finely as fits the budget while it moves, in full once it rests. Meanwhile the last
//! picture is carried to where the view is.

pub(crate) mod image;

use std::time::Duration;

use crate::app::model::picture::{CarryKey, ColorBy, LiveKey};
use crate::app::model::{Same, State};
use crate::app::work::worker::Wanted;
use overlook_engine::capture::Camera;
use overlook_engine::render::Vantage;
use overlook_engine::settings::Backend;

/// A picture is not carried to where the view looks elsewhere by more than this, as a cosine.
const MOST_TURNED: f64 = 0.75;

/// Nor by more than this many distances to what is orbited.
const FARTHEST: f64 = 0.5;

impl State {
    /// Notes whether the live view moves.
    pub(crate) fn follow_view(&mut self) {
        let Some(camera) = self.live_camera(self.live.size) else { return };
        let vantage = Vantage { camera, frame: self.timeline.frame };
        let edited = self.edited_shown().cloned().map(Same);
        self.doc.motion.follow(vantage, edited, self.live.is_held, self.timeline.playing);
    }
}

impl Wanted for LiveKey {
    fn wanted(state: &State) -> Option<Self> {
        let scene = state.doc.scene.as_ref()?;
        let edited = state.edited_shown();
        let samples = edited.or_else(|| state.samples_here())?;
        let coarse = state.live.orbit.as_ref()?.size_in_motion(state.live.size);
        let quality = Self::changes_in(state).map(|_| state.doc.motion.budget.quality());
        // Sampling colors compare samples with pixels, so that they depend on the resolution.
        let fine = match state.live.color_by {
            ColorBy::SamplingRate => coarse,
            _ => state.live.orbit.as_ref()?.size_at_rest(state.live.size),
        };
        let at_rest = &state.settings.render;
        let (size, settings) = quality
            .map_or_else(|| (fine, at_rest.clone()), |quality| (quality.size(coarse), quality.of(at_rest)));
        let on_gpu =
            state.doc.live_shown.as_ref().is_some_and(|shown| shown.picture.painter.backend == Backend::Gpu);
        // The adapter shows colors as recorded.
        let in_motion = state.live.shares_device && on_gpu && quality.is_some() && state.display.is_neutral();
        let is_agreement = state.live.color_by == ColorBy::Agreement;
        Some(Self {
            scene: scene.id,
            samples: Same(samples.clone()),
            // What edits leave is in memory.
            playback: scene.playback().filter(|_| edited.is_none()).cloned().map(Same),
            vantage: Vantage { camera: state.live_camera(size)?, frame: state.timeline.frame },
            settings,
            color_by: state.live.color_by,
            inspection: state.inspection_here().filter(|_| is_agreement).cloned().map(Same),
            holes: state.live.holes,
            cameras: state.live.cameras.clone(),
            display: state.display,
            dark: state.dark,
            in_motion,
            quality,
            per_coarse_pixel: f64::from(size[0]) / f64::from(coarse[0]),
        })
    }

    /// Neither is a whole picture once the view moves on, nor a coarse one once it rests, unless it is the first that shows other samples:
    /// that in full takes much longer.
    fn is_of_use(&self, state: &State) -> bool {
        let shown = state.doc.live_shown.as_ref();
        let shows_more = shown.is_none_or(|shown| shown.key.samples != self.samples);
        (self.quality.is_some() && shows_more) || self.quality.is_some() == Self::changes_in(state).is_some()
    }

    /// How long until the view rests. While a threshold is dragged the next picture follows at once, too.
    fn changes_in(state: &State) -> Option<Duration> {
        state.doc.motion.rests_in(state.doc.changed_at)
    }
}

impl Wanted for CarryKey {
    /// `None` where the picture was taken from where the view is now, or from nowhere near.
    fn wanted(state: &State) -> Option<Self> {
        let (shown, orbit) = (state.doc.live_shown.as_ref()?, state.live.orbit.as_ref()?);
        shown.picture.rendered()?;
        let to = state.live_camera(shown.picture.size.map(|side| side as u32))?;
        let from = &shown.key.vantage.camera;
        let is_needed = to != *from && is_near(from, &to, FARTHEST * orbit.pivot_distance);
        is_needed.then(|| Self {
            scene: shown.key.scene,
            picture: Same(shown.picture.clone()),
            from: from.clone(),
            to,
        })
    }

    fn is_of_use(&self, state: &State) -> bool {
        Self::wanted(state).is_some()
    }
}

fn is_near(from: &Camera, to: &Camera, farthest: f64) -> bool {
    let apart = (from.position_in_world() - to.position_in_world()).length();
    from.forward_in_world().dot(to.forward_in_world()) > MOST_TURNED && apart < farthest
}
