//! Ranks in histograms, whatever their bins are.

/// The bin that the `rank`-th smallest of the counted numbers falls into, counted from 1; `None` beyond the last.
pub(crate) fn bin_of_rank(counts: impl IntoIterator<Item = u64>, rank: u64) -> Option<usize> {
    let mut up_to = 0;
    counts.into_iter().position(|count| {
        up_to += count;
        up_to >= rank
    })
}

/// The rank, counted from 1, of the smallest number that a share of `total` numbers, 0 to 1, does not exceed.
pub(crate) fn rank_of_share(total: u64, share: f64) -> u64 {
    (total as f64 * share).ceil() as u64
}

/// Position of the median in a histogram, in bins, interpolated within its bin; `None` where nothing was counted.
pub(super) fn median_bin(bins: &[u64]) -> Option<f32> {
    let total: u64 = bins.iter().sum();
    if total == 0 {
        return None;
    }
    let half = total as f64 / 2.0;
    let bin = bin_of_rank(bins.iter().copied(), half.ceil() as u64)?;
    let below: u64 = bins[..bin].iter().sum();
    Some(bin as f32 + ((half - below as f64) / bins[bin] as f64) as f32)
}
