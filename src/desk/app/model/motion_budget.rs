//! How the live view moves, and how much of the settings a picture in motion keeps: as much as fits a budget of time, by what earlier
//! pictures took.

use overlook_engine::settings::{Antialias, Coarse, Magnified, RenderSettings};

/// Milliseconds that a picture may take while the view moves: pictures that are carried to the new viewpoint fill the time between.
const BUDGET_MS: f64 = 70.0;

/// Share of the time of a frame that its picture may take while time passes.
const SHARE_OF_FRAME: f64 = 0.65;

/// A finer step is taken where its picture is expected to take at most this share of the budget.
const COMFORTABLE: f64 = 0.75;

/// The share for a step that was taken before.
const KNOWN_COMFORTABLE: f64 = 0.85;

/// The share for another step while time passes: the still part of the scene is painted anew for each step that is tried.
const COMFORTABLE_IN_TIME: f64 = 0.4;

/// Each picture of a coarser step forgets this share of a step's time, so that the step is tried again.
const FORGOTTEN: f64 = 0.015;

/// A coarser step is worth its loss where it takes less than one part in this many of the time.
const WORTH_WHILE: f64 = 1.6;

/// What a picture in motion keeps of the settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionQuality {
    /// Columns and rows, as a share of those that the lens recorded.
    pub scale: f64,
    antialias: bool,
    free_space: bool,
    /// Most cameras whose colors are averaged.
    views: u32,
    /// Expected time, as a share of that of the first step: samples are projected whatever the picture shows.
    cost: f64,
}

/// What gives way, in this order: resolution, antialiasing, the quality of fillings, averaged cameras, and resolution once more.
const STEPS: [MotionQuality; 8] = [
    MotionQuality { scale: 1.0, antialias: true, free_space: true, views: u32::MAX, cost: 1.0 },
    MotionQuality { scale: 0.7, antialias: true, free_space: true, views: u32::MAX, cost: 0.5 },
    MotionQuality { scale: 0.5, antialias: true, free_space: true, views: u32::MAX, cost: 0.29 },
    MotionQuality { scale: 0.5, antialias: false, free_space: true, views: u32::MAX, cost: 0.16 },
    MotionQuality { scale: 0.5, antialias: false, free_space: false, views: u32::MAX, cost: 0.15 },
    MotionQuality { scale: 0.5, antialias: false, free_space: false, views: 1, cost: 0.14 },
    MotionQuality { scale: 0.35, antialias: false, free_space: false, views: 1, cost: 0.13 },
    MotionQuality { scale: 0.25, antialias: false, free_space: false, views: 1, cost: 0.12 },
];

impl MotionQuality {
    /// The settings of a picture in motion.
    pub(crate) fn of(self, at_rest: &RenderSettings) -> RenderSettings {
        RenderSettings {
            coarse: Coarse::Pyramid,
            antialias: if self.antialias { at_rest.antialias.in_motion() } else { Antialias::Off },
            free_space: at_rest.free_space && self.free_space,
            magnified: if self.antialias { at_rest.magnified } else { Magnified::Direct },
            views: at_rest.views.min(self.views),
            ..at_rest.clone()
        }
    }

    /// The size of a picture in motion, given that of the lens.
    pub(crate) fn size(self, [width, height]: [u32; 2]) -> [u32; 2] {
        [width, height].map(|side| ((f64::from(side) * self.scale).round() as u32).max(1))
    }
}

/// Chooses the quality of pictures in motion.
#[derive(Debug, Default)]
pub(crate) struct MotionBudget {
    step: usize,
    /// Milliseconds that pictures of each step took lately.
    took_ms: [Option<f64>; STEPS.len()],
}

impl MotionBudget {
    /// The quality of the next picture in motion.
    pub(crate) fn quality(&self) -> MotionQuality {
        STEPS[self.step]
    }

    /// A resting picture with this many times the pixels of one in motion took this long. It tells where to begin.
    pub(crate) fn rested(&mut self, took_ms: f64, pixels: f64) {
        if self.took_ms.iter().all(Option::is_none) {
            let whole = took_ms / pixels.max(1.0);
            let fits = |step: &MotionQuality| whole * step.cost <= BUDGET_MS;
            self.step = STEPS.iter().position(fits).unwrap_or(STEPS.len() - 1);
        }
    }

    /// A picture in motion of some quality took this long; `frame_rate` while time passes.
    pub(crate) fn moved(&mut self, quality: MotionQuality, took_ms: f64, frame_rate: Option<f32>) {
        let budget_ms = budget_ms(frame_rate);
        let (comfortable, forgotten) =
            if frame_rate.is_some() { (COMFORTABLE_IN_TIME, 0.0) } else { (COMFORTABLE, FORGOTTEN) };
        let Some(at) = STEPS.iter().position(|step| *step == quality) else { return };
        let before = self.took_ms[at];
        let took_ms = before.map_or(took_ms, |before| f64::midpoint(before, took_ms));
        self.took_ms[at] = Some(took_ms);
        if at != self.step {
            return;
        }
        for finer in self.took_ms[..at].iter_mut().flatten() {
            *finer *= 1.0 - forgotten;
        }
        let expected =
            |step: usize| self.took_ms[step].unwrap_or(took_ms * STEPS[step].cost / STEPS[at].cost);
        let coarser = || at + 1..STEPS.len();
        let is_unknown = |step: &usize| self.took_ms[*step].is_none();
        if took_ms > budget_ms
            && let Some(next) = coarser().find(is_unknown)
        {
            let fits = |step: &usize| is_unknown(step) && expected(*step) <= budget_ms;
            self.step = coarser().find(fits).unwrap_or(next);
            return;
        }
        // Where nothing fits, quality is not given away for little.
        let least = self.took_ms.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let affordable = budget_ms.max(WORTH_WHILE * least);
        let is_better = |step: &usize| {
            let share = if is_unknown(step) { comfortable } else { KNOWN_COMFORTABLE };
            expected(*step) <= share * affordable
        };
        if took_ms > affordable {
            self.step = coarser().find(|step| expected(*step) <= affordable).unwrap_or(STEPS.len() - 1);
        } else if let Some(finer) = (0..at).find(is_better) {
            self.step = finer;
        }
    }
}

/// Milliseconds that a picture may take; `frame_rate` while time passes.
fn budget_ms(frame_rate: Option<f32>) -> f64 {
    let of_frame = frame_rate.map_or(f64::INFINITY, |rate| SHARE_OF_FRAME * 1e3 / f64::from(rate));
    BUDGET_MS.min(of_frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures in motion on a machine where the finest takes `finest_ms`; gives the step after `pictures` of them.
    fn settled(budget: &mut MotionBudget, finest_ms: f64, pictures: usize) -> usize {
        for _ in 0..pictures {
            let quality = budget.quality();
            budget.moved(quality, finest_ms * quality.cost, None);
        }
        budget.step
    }

    #[test]
    fn what_fits_the_budget_is_found_within_a_few_pictures_and_kept() {
        // Where no step fits, each is tried once.
        for (finest_ms, expected, few) in
            [(50.0, 0, 1), (100.0, 1, 1), (300.0, 3, 1), (5000.0, 3, STEPS.len())]
        {
            let mut budget = MotionBudget::default();
            assert_eq!(settled(&mut budget, finest_ms, few), expected, "{finest_ms}");
            assert_eq!(settled(&mut budget, finest_ms, 20), expected, "{finest_ms}");
        }
    }

    #[test]
    fn quality_comes_back_where_pictures_become_cheaper() {
        let mut budget = MotionBudget::default();
        assert_eq!(settled(&mut budget, 600.0, STEPS.len()), 3);
        assert_eq!(settled(&mut budget, 20.0, 400), 0);
    }

    #[test]
    fn a_resting_picture_tells_where_motion_begins_unless_motion_has_told() {
        let mut budget = MotionBudget::default();
        budget.rested(400.0, 4.0);
        assert_eq!(budget.step, 1);
        budget.moved(budget.quality(), 60.0, None);
        budget.rested(4000.0, 1.0);
        assert_eq!(budget.step, 1);
    }

    #[test]
    fn while_time_passes_a_picture_takes_less_than_a_frame() {
        assert!(budget_ms(Some(24.0)) < 1e3 / 24.0);
        assert_eq!(budget_ms(Some(2.0)), BUDGET_MS);
    }

    #[test]
    fn nothing_is_switched_on_that_the_settings_switch_off() {
        let off =
            RenderSettings { antialias: Antialias::Off, free_space: false, views: 1, ..Default::default() };
        for step in STEPS {
            let settings = step.of(&off);
            assert!(settings.antialias == Antialias::Off && !settings.free_space && settings.views == 1);
        }
        assert_eq!(STEPS[2].size([641, 3]), [321, 2]);
    }
}
