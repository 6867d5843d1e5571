//! Which contexts share a table, and the frequencies in it.

use super::rans::{SCALE, TOKENS};

/// How often each token was seen.
pub(super) type TokenCounts = [u32; TOKENS];

/// Bytes that a token costs in a stored table, about.
const BYTES_PER_TOKEN: f64 = 1.4;

/// Bytes that a table must save beyond its own: fewer tables decode faster, since they stay in the processor's cache.
const BYTES_WORTH_A_TABLE: f64 = 30.0;

/// What coding a histogram's tokens with a table of their own costs, table included, bits.
fn cost(histogram: &TokenCounts) -> f64 {
    let total: f64 = histogram.iter().map(|count| f64::from(*count)).sum();
    if total == 0.0 {
        return 0.0;
    }
    let used = histogram.iter().filter(|count| **count > 0);
    let tokens: f64 = used.clone().map(|count| f64::from(*count) * (total / f64::from(*count)).log2()).sum();
    tokens + 8.0 * (2.0 + BYTES_WORTH_A_TABLE + BYTES_PER_TOKEN * used.count() as f64)
}

fn sum(a: &TokenCounts, b: &TokenCounts) -> TokenCounts {
    std::array::from_fn(|token| a[token].saturating_add(b[token]))
}

/// Joins neighboring contexts while that saves bits: of each run of contexts their number, and what was counted in them.
///
/// Greedy: the pair that saves most first. Contexts that were never seen cost nothing to join.
pub(super) fn share_tables(contexts: &[TokenCounts]) -> Vec<(usize, TokenCounts)> {
    /// Neighboring contexts that share a table.
    struct ContextRun {
        length: usize,
        histogram: TokenCounts,
        cost: f64,
        /// Bits saved by joining the next run.
        gain: f64,
    }
    let mut runs: Vec<ContextRun> = Vec::new();
    for histogram in contexts {
        match runs.last_mut() {
            Some(last) if histogram.iter().all(|count| *count == 0) => last.length += 1,
            _ => runs.push(ContextRun { length: 1, histogram: *histogram, cost: cost(histogram), gain: 0.0 }),
        }
    }
    let gain = |a: &ContextRun, b: &ContextRun| a.cost + b.cost - cost(&sum(&a.histogram, &b.histogram));
    for index in 1..runs.len() {
        runs[index - 1].gain = gain(&runs[index - 1], &runs[index]);
    }
    while runs.len() > 1 {
        let last = runs.len() - 1;
        let best = (0..last).max_by(|a, b| runs[*a].gain.total_cmp(&runs[*b].gain)).unwrap_or(0);
        if runs[best].gain < 0.0 {
            break;
        }
        let joined = runs.remove(best + 1);
        let run = &mut runs[best];
        run.length += joined.length;
        run.histogram = sum(&run.histogram, &joined.histogram);
        run.cost = cost(&run.histogram);
        if best + 1 < runs.len() {
            runs[best].gain = gain(&runs[best], &runs[best + 1]);
        }
        if best > 0 {
            runs[best - 1].gain = gain(&runs[best - 1], &runs[best]);
        }
    }
    runs.into_iter().map(|run| (run.length, run.histogram)).collect()
}

/// Frequencies that add up to [`SCALE`], at least 1 for whatever was counted.
pub(super) fn frequencies(histogram: &TokenCounts) -> Vec<u16> {
    let total: u64 = histogram.iter().map(|count| u64::from(*count)).sum();
    let mut frequencies = vec![0_u16; TOKENS];
    if total == 0 {
        frequencies[0] = SCALE as u16;
        return frequencies;
    }
    for (frequency, &count) in frequencies.iter_mut().zip(histogram) {
        let share = (u64::from(count) * u64::from(SCALE) + total / 2) / total;
        *frequency = if count == 0 { 0 } else { share.max(1) as u16 };
    }
    // The most frequent token takes what rounding left over, or gives what is missing: there it costs least.
    let mut sum: i32 = frequencies.iter().map(|frequency| i32::from(*frequency)).sum();
    while sum != SCALE as i32 {
        let most = (0..TOKENS).max_by_key(|token| frequencies[*token]).unwrap_or(0);
        let change = (SCALE as i32 - sum).max(-i32::from(frequencies[most]) / 2);
        frequencies[most] = (i32::from(frequencies[most]) + change) as u16;
        sum += change;
    }
    frequencies
}
