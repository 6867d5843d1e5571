//! The range over a number of frames that noise alone explains.
//!
//! Source: the range of `n` normal draws is that of Tippett, *On the extreme individuals and the range of samples*, Biometrika
//! 1925: `P(range ≤ r) = n ∫ φ(x) [Φ(x + r) − Φ(x)]^(n−1) dx`.

/// Share of static pixels that the granted range must hold; what is lost goes to the foreground, which costs bytes only.
const STATIC_SHARE: f64 = 0.9998;

/// The range, in standard deviations, that all but a fraction of a permille of static pixels keep within over `draws`
/// frames. 0 for fewer than two draws.
#[must_use]
pub fn granted_range_sigmas(draws: usize) -> f32 {
    if draws < 2 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0_f64, 20.0_f64);
    for _ in 0..40 {
        let middle = f64::midpoint(low, high);
        if range_probability(draws, middle) < STATIC_SHARE { low = middle } else { high = middle }
    }
    high as f32
}

/// `P(range ≤ r)` of `draws` standard normal draws, by the trapezoidal rule (spectrally accurate on this integrand).
fn range_probability(draws: usize, r: f64) -> f64 {
    const STEP: f64 = 0.02;
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let cumulative: Vec<f64> = {
        let mut sum = 0.0;
        (-500..=1600)
            .map(|i| {
                let cell = density(f64::from(i) * STEP) * STEP;
                sum += cell;
                sum - 0.5 * cell
            })
            .collect()
    };
    let shift = r / STEP;
    let mut probability = 0.0;
    for (i, &below) in cumulative.iter().enumerate().take(1001) {
        let x = (i as f64 - 500.0) * STEP;
        let position = (i as f64 + shift).min(cumulative.len() as f64 - 2.0);
        let cell = position.floor();
        let above = {
            let (a, b) = (cumulative[cell as usize], cumulative[cell as usize + 1]);
            a + (b - a) * (position - cell)
        };
        probability += density(x) * (above - below).max(0.0).powi(draws as i32 - 1) * STEP;
    }
    draws as f64 * probability
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_distribution_meets_published_tables() {
        // Upper 5 % points of the studentized range with infinite degrees of freedom (Harter 1960).
        for (draws, point) in [(2, 2.772), (5, 3.858), (10, 4.474), (60, 5.764)] {
            assert!((range_probability(draws, point) - 0.95).abs() < 2e-3, "{draws}");
        }
        assert!(granted_range_sigmas(60) > granted_range_sigmas(2));
        assert_eq!(granted_range_sigmas(1), 0.0);
    }
}
