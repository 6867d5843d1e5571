//! Where a capture is cut.

use crate::part::Part;
use crate::samples::Span;

/// Units of frames for each part, about: runs then differ by a quarter at most.
const UNITS: usize = 4;

/// The frames of a part of a capture of `frames` frames: whole spans of the tree, which begin at a multiple of their length. Empty
/// where there are more parts than frames.
#[must_use]
pub fn run_of_part(frames: usize, part: Part) -> Span {
    let unit = 1 << (frames / (UNITS * part.of() as usize)).max(1).ilog2();
    let units = part.range(frames.div_ceil(unit));
    let frame = |unit_index: usize| (unit_index * unit).min(frames) as u32;
    Span { start: frame(units.start), end: frame(units.end) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_each_frame_once_and_begin_where_long_spans_do() {
        for (frames, of) in [(60, 6), (3000, 256), (61, 7), (3, 5), (1, 1)] {
            let runs: Vec<Span> = Part::all(of).map(|part| run_of_part(frames, part)).collect();
            let all: Vec<u32> = runs.iter().flat_map(|run| run.start..run.end).collect();
            assert_eq!(all, (0..frames as u32).collect::<Vec<_>>(), "{frames} in {of}");
            let lengths = || runs.iter().map(|run| run.len());
            let [most, least] = [lengths().max().unwrap(), lengths().min().unwrap()];
            assert!(most <= least + (least / 2).max(1), "{frames} in {of}: {least} to {most}");
        }
        assert_eq!(run_of_part(3000, "1/16".parse().unwrap()), Span { start: 0, end: 160 });
    }
}
