//! Time: the frame that is shown, playback, and when samples last.

mod control;
pub(crate) mod ui;

use std::collections::{BTreeSet, VecDeque};
use std::time::{Duration, Instant};

/// Where in time.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "ways in which time passes, each by its name")]
pub(crate) struct Timeline {
    pub frame: usize,
    /// Whether it advances.
    pub playing: bool,
    /// Whether it will by itself, once what is asked for is open.
    pub plays_once_open: bool,
    pub frames_per_second: f32,
    /// Seconds since the last advance.
    pub elapsed_secs: f32,
    /// First and last frame that are played; `None` plays all frames.
    pub range: Option<[usize; 2]>,
    /// Whether playback turns back at either end.
    pub ping_pong: bool,
    /// Whether it goes back now.
    pub backward: bool,
    /// Frames that are marked.
    pub markers: BTreeSet<usize>,
    /// How many frames are really shown while it advances.
    pub shown: ShownRate,
}

/// How long frames that were shown are counted.
const COUNTED: Duration = Duration::from_secs(1);

/// Counts the frames that are shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ShownRate {
    last: Option<usize>,
    /// When those of the last second were shown.
    times: VecDeque<Instant>,
}

impl ShownRate {
    /// A picture of a frame is shown.
    pub(crate) fn add(&mut self, frame: usize, now: Instant) {
        if self.last.replace(frame) != Some(frame) {
            self.times.push_back(now);
        }
        while self.times.front().is_some_and(|time| now - *time > COUNTED) {
            self.times.pop_front();
        }
    }

    /// Frames a second; `None` before there are enough of them.
    pub(crate) fn per_second(&self) -> Option<f32> {
        let (first, last) = (self.times.front()?, self.times.back()?);
        let passed = (*last - *first).as_secs_f32();
        (passed > 0.5).then(|| (self.times.len() - 1) as f32 / passed)
    }
}

impl Timeline {
    /// At the start of another scene, passing as before.
    pub(crate) fn at_start(&self) -> Self {
        Self {
            plays_once_open: self.plays_once_open,
            frames_per_second: self.frames_per_second,
            ping_pong: self.ping_pong,
            ..Self::default()
        }
    }

    /// Shows a frame; the last one where there are fewer.
    pub(crate) fn go_to(&mut self, frame: usize, frames: usize) {
        self.frame = frame.min(frames.saturating_sub(1));
    }

    /// First and last frame of what is played, of `frames` frames, one at least.
    pub(crate) fn played(&self, frames: usize) -> [usize; 2] {
        let last = frames.saturating_sub(1);
        self.range.map_or([0, last], |[first, end]| {
            let first = first.min(last);
            [first, end.clamp(first, last)]
        })
    }

    /// Lets time pass by some frames.
    pub(crate) fn advance(&mut self, by: usize, frames: usize) {
        let [first, last] = self.played(frames);
        if !(first..=last).contains(&self.frame) {
            (self.frame, self.backward) = (first, false);
            return;
        }
        let (length, at) = (last - first, self.frame - first);
        if !self.ping_pong || length == 0 {
            self.frame = first + (at + by) % (length + 1);
            return;
        }
        // There and back is one round.
        let place = if self.backward { 2 * length - at } else { at };
        let place = (place + by) % (2 * length);
        self.backward = place >= length;
        self.frame = first + if self.backward { 2 * length - place } else { place };
    }

    /// The next marker after this frame, or the last one before it; around the ends. Without any, this frame.
    pub(crate) fn marker(&self, forward: bool) -> usize {
        let (before, after) = (self.markers.range(..self.frame), self.markers.range(self.frame + 1..));
        let (first, last) = (self.markers.first(), self.markers.last());
        let found = if forward { after.min().or(first) } else { before.max().or(last) };
        found.copied().unwrap_or(self.frame)
    }

    /// Marks this frame, or takes its marker away.
    pub(crate) fn toggle_marker(&mut self) {
        if !self.markers.remove(&self.frame) {
            self.markers.insert(self.frame);
        }
    }

    /// The range as it is where it begins at this frame, or where it ends there.
    pub(crate) fn range_here(&self, begins: bool, frames: usize) -> [usize; 2] {
        let [first, last] = self.played(frames);
        if begins { [self.frame, last.max(self.frame)] } else { [first.min(self.frame), self.frame] }
    }
}

/// What concerns time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TimeCommand {
    Frame(usize),
    /// Step forward or back, around the ends.
    Step(i64),
    TogglePlay,
    /// Let time pass otherwise: another range or rate, other markers, or other ways at the ends.
    Change(Box<Timeline>),
}

impl TimeCommand {
    /// The command that lets time pass as a change makes it.
    pub(crate) fn change(timeline: &Timeline, change: impl FnOnce(&mut Timeline)) -> Self {
        let mut timeline = Box::new(timeline.clone());
        change(&mut timeline);
        Self::Change(timeline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn played(mut timeline: Timeline, steps: usize) -> Vec<usize> {
        let step = |_| {
            timeline.advance(1, 10);
            timeline.frame
        };
        (0..steps).map(step).collect()
    }

    #[test]
    fn time_passes_around_the_ends_of_the_range_or_back_and_forth() {
        let all = Timeline { frame: 8, ..Timeline::default() };
        assert_eq!(played(all, 3), [9, 0, 1]);
        let range = Timeline { frame: 4, range: Some([3, 5]), ..Timeline::default() };
        assert_eq!(played(range.clone(), 4), [5, 3, 4, 5]);
        let outside = Timeline { frame: 9, ..range.clone() };
        assert_eq!(played(outside, 2), [3, 4]);
        let both_ways = Timeline { ping_pong: true, ..range.clone() };
        assert_eq!(played(both_ways, 6), [5, 4, 3, 4, 5, 4]);
        let one = Timeline { range: Some([4, 4]), ping_pong: true, ..range };
        assert_eq!(played(one, 2), [4, 4]);
    }

    #[test]
    fn frames_that_are_shown_are_counted_once_over_the_last_second() {
        let start = Instant::now();
        let mut shown = ShownRate::default();
        let at = |ms: u64| start + Duration::from_millis(ms);
        shown.add(0, at(0));
        assert_eq!(shown.per_second(), None);
        for nth in 1..=100 {
            shown.add(nth as usize, at(nth * 50));
            shown.add(nth as usize, at(nth * 50));
        }
        assert!((shown.per_second().unwrap() - 20.0).abs() < 0.01);
        (1..=20).for_each(|nth| shown.add(1000 + nth as usize, at(5000 + nth * 200)));
        assert!((shown.per_second().unwrap() - 5.0).abs() < 0.01);
    }

    #[test]
    fn an_end_that_is_moved_past_the_other_takes_it_along() {
        let at = |frame| Timeline { frame, range: Some([3, 5]), ..Timeline::default() };
        assert_eq!(at(7).range_here(true, 10), [7, 7]);
        assert_eq!(at(1).range_here(false, 10), [1, 1]);
        assert_eq!(at(0).played(5), [3, 4], "a range of a longer capture is cut");
    }

    #[test]
    fn markers_are_met_in_their_order_and_around_the_ends() {
        let mut timeline = Timeline::default();
        assert_eq!(timeline.marker(true), 0);
        for frame in [7, 2] {
            timeline.frame = frame;
            timeline.toggle_marker();
        }
        let met = |frame, forward| Timeline { frame, ..timeline.clone() }.marker(forward);
        assert_eq!([met(2, true), met(7, true), met(4, true)], [7, 2, 7]);
        assert_eq!([met(2, false), met(7, false), met(4, false)], [7, 2, 2]);
        timeline.toggle_marker();
        assert_eq!(timeline.markers.into_iter().collect::<Vec<_>>(), [7]);
    }
}
