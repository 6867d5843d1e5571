//! The value of `normal_space`.

use serde::{Deserialize, Serialize};

/// The value of `normal_space`. Null is not the same as a missing key: the file's value counts for a missing one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum NormalSpaceName {
    /// A name, `world` or `camera`.
    Text(String),
    /// No normals are to be read.
    Null,
}

pub(super) fn present<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<NormalSpaceName>, D::Error> {
    NormalSpaceName::deserialize(deserializer).map(Some)
}
