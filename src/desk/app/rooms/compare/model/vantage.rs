//! Where a comparison is made from.

/// From where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum CompareVantage {
    /// The pose of the live view.
    Live,
    /// A vantage whose truth is known, by its place among those.
    Truth(usize),
    /// A camera, whose own samples are left out.
    HoldOut(usize),
}
