//! Pairing by time stamps.

/// The index of the time nearest to `time`, where it is within `limit` seconds; of two equally near ones the earlier. `times` are
/// finite and ascending.
pub(crate) fn nearest(times: &[f64], time: f64, limit: f64) -> Option<usize> {
    let after = times.partition_point(|other| *other < time);
    let around = [after.checked_sub(1), (after < times.len()).then_some(after)];
    let apart = |index: &usize| (times[*index] - time).abs();
    around
        .into_iter()
        .flatten()
        .min_by(|a, b| apart(a).total_cmp(&apart(b)))
        .filter(|index| apart(index) <= limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_stamp_counts_within_its_limit() {
        let times = [1.0, 2.0, 2.5];
        assert_eq!(nearest(&times, 2.2, 0.5), Some(1));
        assert_eq!(nearest(&times, 1.5, 0.5), Some(0), "the earlier of two");
        assert_eq!(nearest(&times, 9.0, 0.5), None);
        assert_eq!(nearest(&times, 0.9, 0.11), Some(0));
        assert_eq!(nearest(&[], 0.9, 9.0), None);
    }
}
