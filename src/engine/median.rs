//! Medians, which strays do not move.
//!
//! For an even number of values it is the **upper** one of the two in the middle: the one at place `n / 2` from 0 on, in ascending
//! order. It is always one of the values, never a mean of two. Values that are not a number count as the total order of IEEE 754 puts
//! them: NaN above +∞, negative NaN below −∞.

use std::cmp::Ordering;

/// Φ⁻¹(0.75): the median of the magnitude of a normal draw, in standard deviations.
pub(crate) const MEDIAN_PER_SIGMA: f64 = 0.6745;

/// The upper median; `None` of nothing. Reorders the values.
pub fn median(values: &mut [f64]) -> Option<f64> {
    median_by(values, f64::total_cmp)
}

/// The upper median of single precision; `None` of nothing. Reorders the values.
pub fn median_f32(values: &mut [f32]) -> Option<f32> {
    median_by(values, f32::total_cmp)
}

/// The upper median in an order; `None` of nothing. Reorders the values. Which one of several in the middle that are equal in this
/// order it is, is the same in every run.
pub fn median_by<T: Copy>(values: &mut [T], order: impl Fn(&T, &T) -> Ordering) -> Option<T> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, order).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_an_even_number_of_values_the_upper_one_of_the_middle_counts() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), Some(3.0));
        assert_eq!(median_f32(&mut [2.0, 1.0]), Some(2.0));
        assert_eq!(median_by(&mut [(1, 'a'), (3, 'b'), (2, 'c')], |a, b| a.0.cmp(&b.0)), Some((2, 'c')));
    }

    #[test]
    fn nothing_has_no_median_and_nan_counts_as_the_largest() {
        assert_eq!((median(&mut []), median_f32(&mut [])), (None, None));
        assert_eq!(median(&mut [f64::NAN, 1.0, f64::INFINITY]), Some(f64::INFINITY));
        assert!(median(&mut [f64::NAN, 1.0]).is_some_and(f64::is_nan));
        assert_eq!(median(&mut [-f64::NAN, f64::NEG_INFINITY, 0.0]), Some(f64::NEG_INFINITY));
    }
}
