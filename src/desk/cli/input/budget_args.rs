//! Options of work that may be cut short by time.

use std::time::Duration;

use clap::Args;

use crate::cli::output;
use overlook_engine::plural::counted;

/// How long to measure.
#[derive(Debug, Args)]
pub(crate) struct BudgetArgs {
    /// Stop measuring after this time, in seconds or as in 3min or 1h, and write what is known then; the same command goes on from
    /// there. Coarse comes first: both ends of every dial, then their middles.
    #[arg(long, value_name = "SECONDS|3min", value_parser = duration)]
    pub(crate) budget: Option<Duration>,
}

impl BudgetArgs {
    /// Says that measurements are left, if any are.
    pub(crate) fn warn_of(left: usize) {
        if left > 0 {
            let words = counted(left, "measurement");
            output::warn(&[format!("the budget is spent with {words} left; the same command goes on")]);
        }
    }
}

fn duration(text: &str) -> Result<Duration, String> {
    let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0), ("", 1.0)];
    let seconds = units.into_iter().find_map(|(unit, seconds)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        Some(number * seconds)
    });
    let duration = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.ok_or_else(|| "must be a time, as in 90, 90s, 3min or 1h".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_unit_and_nonsense_is_refused() {
        for (text, seconds) in [("90", 90.0), ("90s", 90.0), ("3min", 180.0), ("0.5 h", 1800.0), ("0", 0.0)] {
            assert_eq!(duration(text).map(|time| time.as_secs_f64()), Ok(seconds), "{text}");
        }
        for text in ["", "min", "-3", "nan", "inf", "1e300", "3 days", "3m"] {
            assert!(duration(text).is_err(), "{text}");
        }
    }
}
