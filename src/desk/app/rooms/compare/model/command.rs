//! What concerns the comparison of two pictures.

use super::comparison::CompareLook;

/// What concerns the comparison of two pictures.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CompareCommand {
    Look(Box<CompareLook>),
    /// Close the pictures of another program, by their folder's number.
    ClosePictures(u64),
}
