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
