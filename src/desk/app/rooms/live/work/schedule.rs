//! When the live view is painted, and how: at once and as finely as fits the budget while it moves, in full once it rests. Meanwhile the
//! last picture is carried to where the view is.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::app::model::{Same, State};
use crate::app::rooms::live::model::{CarryKey, ColorBy, LiveKey, LivePicture, MotionBudget};
use crate::app::work::workers::Workers;
use overlook_engine::capture::Camera;
use overlook_engine::render::Vantage;
use overlook_engine::settings::Backend;

/// The live view is at rest after this long at one vantage.
const REST: Duration = Duration::from_millis(120);

/// The same while a button is held: whoever drags may pause.
const REST_WHILE_HELD: Duration = Duration::from_millis(200);

/// A picture is not carried to where the view looks elsewhere by more than this, as a cosine.
const MOST_TURNED: f64 = 0.75;

/// Nor by more than this many distances to what is orbited.
const FARTHEST: f64 = 0.5;

/// The last requests of the live view.
#[derive(Default)]
pub(crate) struct LiveSchedule {
    asked: Option<LiveKey>,
    carried: Option<CarryKey>,
    /// Where the live view looked from and when.
    vantage: Option<Vantage>,
    /// When it last looked elsewhere, or at another frame.
    moved_at: Option<Instant>,
    was_held: bool,
    /// Whether it is painted otherwise once it rests.
    will_change: bool,
    budget: MotionBudget,
}

impl LiveSchedule {
    /// Whether what was asked for last is shown.
    pub(crate) fn is_up_to_date(&self, state: &State) -> bool {
        let is_shown = state.doc.live_shown.as_ref().map(|shown| &shown.key) == self.asked.as_ref();
        is_shown && !self.will_change && state.doc.live_carried.is_none()
    }

    /// Whether a picture is of no use any more: one in motion, after that at rest was asked for.
    pub(crate) fn is_late(&self, key: &LiveKey) -> bool {
        key.quality.is_some() && self.asked.as_ref().is_some_and(|asked| asked.quality.is_none())
    }

    /// Takes in what a picture took.
    pub(crate) fn painted(&mut self, key: &LiveKey, picture: &LivePicture, state: &State) {
        let took_ms = picture.took.as_secs_f64() * 1e3;
        match key.quality {
            // A background that is painted anew as the quality changes is no measure for those that follow.
            Some(_) if state.timeline.playing && !picture.stats.background_reused => {}
            Some(quality) => {
                let rate = state.timeline.playing.then_some(state.timeline.frames_per_second);
                self.budget.moved(quality, took_ms, rate);
            }
            None => self.budget.rested(took_ms, key.per_coarse_pixel.powi(2)),
        }
    }

    /// Requests the picture that the state needs. `changed_at` is when a setting was last changed. Gives the time after which to call
    /// again, if any.
    pub(crate) fn request(
        &mut self,
        state: &State,
        workers: &Workers,
        changed_at: Option<Instant>,
    ) -> Option<Duration> {
        let (key, rests_in) = self.key(state, changed_at)?;
        let moves = key.quality.is_some();
        if self.asked.as_ref() != Some(&key) {
            // What runs is of no use: neither a whole picture once the view moves on, nor a coarse one once it rests.
            if self.asked.as_ref().is_some_and(|asked| asked.quality.is_some() != moves) {
                workers.live.cancel();
            }
            workers.live.submit(key.clone());
            self.asked = Some(key);
        }
        self.request_carried(state, workers);
        rests_in
    }

    /// What is to be painted now, and how long until that changes.
    fn key(&mut self, state: &State, changed_at: Option<Instant>) -> Option<(LiveKey, Option<Duration>)> {
        let scene = state.doc.scene.as_ref()?;
        let edited = state.edited().map(|edited| &edited.shown);
        let samples = edited.or_else(|| state.samples_here())?;
        let orbit = state.live.orbit.as_ref()?;
        let frame = state.timeline.frame;
        let vantage = Vantage { camera: state.live_camera(state.live.size)?, frame };
        let asked = self.asked.as_ref().filter(|_| edited.is_some());
        let is_marked_anew = asked.is_some_and(|asked| !Arc::ptr_eq(&asked.samples, samples));
        let rests_in = self.rests_in(vantage, is_marked_anew, state, changed_at);
        let quality = rests_in.is_some().then(|| self.budget.quality());
        let coarse = orbit.size_in_motion(state.live.size);
        // Sampling colors compare samples with pixels, so that they depend on the resolution.
        let fine = match state.live.color_by {
            ColorBy::SamplingRate => coarse,
            _ => orbit.size_at_rest(state.live.size),
        };
        let at_rest = &state.settings.render;
        let (size, settings) = quality
            .map_or_else(|| (fine, at_rest.clone()), |quality| (quality.size(coarse), quality.of(at_rest)));
        let on_gpu =
            state.doc.live_shown.as_ref().is_some_and(|shown| shown.picture.painter.backend == Backend::Gpu);
        // The adapter shows colors as recorded.
        let in_motion = state.live.shares_device && on_gpu && quality.is_some() && state.display.is_neutral();
        self.will_change = quality.is_some();
        let key = LiveKey {
            scene: scene.id,
            samples: Same(samples.clone()),
            // What edits leave is in memory.
            playback: scene.playback().filter(|_| edited.is_none()).cloned().map(Same),
            vantage: Vantage { camera: state.live_camera(size)?, frame },
            settings,
            color_by: state.live.color_by,
            inspection: state
                .inspection_here()
                .filter(|_| state.live.color_by == ColorBy::Agreement)
                .cloned()
                .map(Same),
            holes: state.live.holes,
            cameras: state.live.cameras.clone(),
            display: state.display,
            dark: state.dark,
            in_motion,
            quality,
            per_coarse_pixel: f64::from(size[0]) / f64::from(coarse[0]),
        };
        Some((key, rests_in))
    }

    /// How long until the view rests; `None` once it does. What is selected or cut anew (`is_marked_anew`) is shown at once, as if the
    /// view had moved.
    fn rests_in(
        &mut self,
        vantage: Vantage,
        is_marked_anew: bool,
        state: &State,
        changed_at: Option<Instant>,
    ) -> Option<Duration> {
        if self.vantage.as_ref() != Some(&vantage) {
            // The first picture is not in motion, unless time passes from the start.
            self.moved_at = (self.vantage.is_some() || state.timeline.playing).then(Instant::now);
            self.vantage = Some(vantage);
        }
        let is_held = state.live.is_held;
        if std::mem::replace(&mut self.was_held, is_held) && !is_held {
            // Whoever lets go has arrived.
            self.moved_at = None;
        }
        if is_marked_anew {
            self.moved_at = Some(Instant::now());
        }
        let rest = if is_held { REST_WHILE_HELD } else { REST };
        // While a threshold is dragged the next picture follows at once, too.
        let since = [self.moved_at, changed_at].into_iter().flatten().map(|at| at.elapsed()).min()?;
        rest.checked_sub(since).filter(|left| !left.is_zero())
    }

    fn request_carried(&mut self, state: &State, workers: &Workers) {
        let key = carry_key(state);
        if let Some(key) = key.as_ref().filter(|key| self.carried.as_ref() != Some(key)) {
            workers.carry.submit(key.clone());
        }
        self.carried = key;
    }
}

/// What is to be carried to where the view is now; `None` where the picture was taken from there, or from nowhere near.
fn carry_key(state: &State) -> Option<CarryKey> {
    let (shown, orbit) = (state.doc.live_shown.as_ref()?, state.live.orbit.as_ref()?);
    shown.picture.rendered()?;
    let to = state.live_camera(shown.picture.size.map(|side| side as u32))?;
    let from = &shown.key.vantage.camera;
    let is_needed = to != *from && is_near(from, &to, FARTHEST * orbit.pivot_distance);
    is_needed.then(|| CarryKey {
        scene: shown.key.scene,
        picture: Same(shown.picture.clone()),
        from: from.clone(),
        to,
    })
}

fn is_near(from: &Camera, to: &Camera, farthest: f64) -> bool {
    let apart = (from.position_in_world() - to.position_in_world()).length();
    from.forward_in_world().dot(to.forward_in_world()) > MOST_TURNED && apart < farthest
}
