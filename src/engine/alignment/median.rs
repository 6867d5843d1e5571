//! Medians, which strays do not move.

/// Φ⁻¹(0.75): the median of the magnitude of a normal draw, in standard deviations.
pub(super) const MEDIAN_PER_SIGMA: f64 = 0.6745;

/// The median, of an even number of values the upper one of the two in the middle; `None` of nothing. Reorders the values.
pub(super) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
