//! What other cameras say of samples: how many confirm each, and how many look past it.

/// The vote of one camera on a sample of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vote {
    /// It sees the surface where the sample has it, whatever its normal and color.
    Confirms,
    /// It sees only farther surfaces there.
    LooksPast,
    /// It does not look there, something is in the way, or it may have missed the surface.
    CannotTell,
}

/// The numbers of other cameras that vote for and against a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VoteCounts {
    /// Those that confirm it.
    pub confirm: u32,
    /// Those that look past it.
    pub look_past: u32,
}

impl VoteCounts {
    /// Votes on the sky, which counts as confirmed by all: depth tells nothing of it.
    pub(crate) const OF_SKY: Self = Self { confirm: u32::MAX / 2, look_past: 0 };

    /// With one more vote.
    #[must_use]
    pub(crate) fn with(mut self, vote: Vote) -> Self {
        self.confirm += u32::from(vote == Vote::Confirms);
        self.look_past += u32::from(vote == Vote::LooksPast);
        self
    }

    /// Whether by `margin` more cameras look past the sample than confirm it. Its own camera is one of the latter.
    /// For a flying pixel the own camera counts among those that look past it, since it saw what is in front and what is behind.
    #[must_use]
    pub fn contradict(self, margin: u32, is_flying: bool) -> bool {
        let (confirm, look_past) =
            (self.confirm + u32::from(!is_flying), self.look_past + u32::from(is_flying));
        look_past >= confirm + margin
    }
}

/// The votes on all samples of some images.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleVotes {
    /// For each image, for each of its samples.
    pub(crate) images: Vec<Vec<VoteCounts>>,
}

impl SampleVotes {
    /// The votes on the samples of an image, in their order; empty where there is no such image.
    #[must_use]
    pub fn of_image(&self, index: usize) -> &[VoteCounts] {
        self.images.get(index).map_or(&[], Vec::as_slice)
    }
}
