//! What the last change of settings did: figures before it and now, and the samples that went or came, seen in the live view.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use std::sync::Arc;

use crate::app::model::same::Same;
use crate::app::model::scene::method_of;
use crate::app::model::state::State;
use crate::app::rooms::change::state::{Difference, Figures};
use crate::text::{bytes, count, significant};
use overlook_engine::samples::SampleSet;

impl Figures {
    /// What is known under the settings on the sliders.
    pub(crate) fn of(state: &State) -> Self {
        let doc = &state.doc;
        let method = method_of(&state.settings);
        let inspected = doc.inspected.as_ref().filter(|inspected| method_of(&inspected.settings) == method);
        let whole = doc.whole.as_ref().filter(|_| !state.is_stale());
        let rests = doc.live_shown.as_ref().filter(|shown| shown.key.quality.is_none());
        Self {
            settings: state.settings.clone(),
            frame: inspected.map(|inspected| (inspected.inspection.frame, inspected.kept.iter().sum())),
            frame_samples: inspected.map(|inspected| Same(inspected.inspection.samples.clone())),
            samples: whole.map(|whole| whole.report.samples_kept),
            bytes: whole.map(|whole| whole.report.bytes_memory),
            psnr_db: doc.accuracy.filter(|_| whole.is_some()).map(|accuracy| accuracy.psnr_db),
            picture_ms: rests.map(|shown| shown.picture.stats.milliseconds),
        }
    }
}

/// The difference of two counts, with its sign and as a share of the first.
fn counted(before: u64, now: u64, text: fn(u64) -> String) -> String {
    let sign = if now < before { "−" } else { "+" };
    let percent = 100.0 * (now as f64 - before as f64) / (before.max(1) as f64);
    format!("{sign}{} ({sign}{} %)", text(now.abs_diff(before)), significant(percent.abs()))
}

fn signed(difference: f64, digits: usize) -> String {
    format!("{difference:+.digits$}").replace('-', "−")
}

/// A figure before and now; `None` where it was not known before.
fn difference<T: Copy>(
    name: &'static str,
    [before, now]: [Option<T>; 2],
    text: impl Fn(T) -> String,
    change: impl Fn(T, T) -> String,
) -> Option<Difference> {
    let before = before?;
    let change = now.map(|now| change(before, now));
    Some(Difference { name, before: text(before), now: now.map(text), change })
}

impl State {
    /// The samples of the frame shown that were kept before the last change of settings and are kept now; `None` without a change, or while
    /// one of them is not known.
    pub(crate) fn changed_samples(&self) -> Option<[Arc<SampleSet>; 2]> {
        let (before, now) = (self.doc.change.before.as_ref()?, Figures::of(self));
        let is_here =
            |figures: &Figures| figures.frame.is_some_and(|(frame, _)| frame == self.timeline.frame);
        let both = [before, &now].map(|figures| figures.frame_samples.clone().filter(|_| is_here(figures)));
        let [Some(Same(before)), Some(Same(now))] = both else { return None };
        Some([before, now])
    }

    /// Figures before the last change of settings and now; empty without a change. What was not known before is left out.
    pub(crate) fn differences(&self) -> Vec<Difference> {
        let Some(before) = &self.doc.change.before else { return Vec::new() };
        let now = Figures::of(self);
        let of_count = |name, of, text: fn(u64) -> String| {
            difference(name, of, text, |before, now| counted(before, now, text))
        };
        let of_number = |name, of, unit: &str, digits: usize| {
            let text = |number: f64| format!("{number:.digits$} {unit}");
            difference(name, of, text, |before, now| signed(now - before, digits) + " " + unit)
        };
        let here = self.timeline.frame;
        let of_frame = |figures: &Figures| figures.frame.filter(|(frame, _)| *frame == here).map(|it| it.1);
        [
            of_count("This frame", [of_frame(before), of_frame(&now)], count),
            of_count("Samples kept", [before.samples, now.samples], count),
            of_count("Memory", [before.bytes, now.bytes], bytes),
            of_number("Accuracy", [before.psnr_db, now.psnr_db], "dB", 2),
            of_number("Live picture", [before.picture_ms, now.picture_ms], "ms", 0),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_has_its_sign_and_its_share() {
        assert_eq!(counted(1_430_000, 1_490_000, count), "+60.0 k (+4.20 %)");
        assert_eq!(counted(200, 150, count), "−50 (−25.0 %)");
        assert_eq!(counted(0, 5, count), "+5 (+500 %)");
        assert_eq!(signed(35.84 - 36.02, 2), "−0.18");
    }

    #[test]
    fn without_a_change_nothing_is_told_and_what_was_not_known_before_is_left_out() {
        let mut state = State::default();
        assert!(state.differences().is_empty());
        let known = Figures { samples: Some(10), ..Figures::of(&state) };
        state.doc.change.before = Some(known);
        let told = state.differences();
        assert_eq!(told.len(), 1, "{told:?}");
        assert_eq!((told[0].name, told[0].now.as_ref()), ("Samples kept", None));
    }
}
