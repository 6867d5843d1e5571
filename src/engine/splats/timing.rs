//! When the splats of a span are seen.

use crate::samples::Span;

/// The frames of a scene in time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing {
    /// How many there are.
    pub(super) frames: usize,
    /// Above 0.
    pub(super) frames_per_second: f64,
}

impl Timing {
    /// Frames at which a span appears or goes, or the scene begins or ends, each with whether the span is seen from there on.
    pub(super) fn changes(self, span: Span) -> Vec<(u32, bool)> {
        let last = self.frames as u32;
        let mut frames = vec![0, span.start, span.end, last];
        frames.dedup();
        let is_seen = |frame: u32| frame >= span.start && (frame < span.end || span.end == last);
        frames.into_iter().map(|frame| (frame, is_seen(frame))).collect()
    }

    /// Whether a span is that of all frames.
    pub(super) fn is_always(self, span: Span) -> bool {
        span.len() == self.frames
    }

    /// Seconds from the first frame to one.
    pub(super) fn seconds(self, frame: u32) -> f32 {
        (f64::from(frame) / self.frames_per_second) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_is_seen_from_its_first_frame_until_the_one_after_its_last() {
        let timing = Timing { frames: 8, frames_per_second: 4.0 };
        let changes = |start: u32, end: u32| timing.changes(Span { start, end });
        assert_eq!(changes(0, 4), [(0, true), (4, false), (8, false)]);
        assert_eq!(changes(3, 5), [(0, false), (3, true), (5, false), (8, false)]);
        assert_eq!(changes(4, 8), [(0, false), (4, true), (8, true)]);
        assert!(timing.is_always(Span { start: 0, end: 8 }) && !timing.is_always(Span { start: 0, end: 4 }));
        assert_eq!(timing.seconds(6), 1.5);
    }
}
