//! The manifest's keys of scalar values.

use serde::{Deserialize, Serialize};

use crate::capture::exr::value_channel;
use crate::capture::values::ValueChannel;

/// One channel of values, as the manifest has it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ValueKeys {
    /// Unlike those of the other channels.
    pub name: String,
    /// For people.
    #[serde(default)]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Smallest and largest value; measured on the first pictures where missing.
    pub range: Option<[f32; 2]>,
    /// How far apart values may be to count as the same; a share of the range where missing.
    pub tolerance: Option<f32>,
    /// Whether stores keep the values bit for bit, as they do where missing, or within half the tolerance.
    pub exact: Option<bool>,
    /// Full name of the channel in OpenEXR; the name where missing.
    pub channel: Option<String>,
}

impl ValueKeys {
    /// The keys of a channel in a capture that we write.
    pub(super) fn of_written(channel: &ValueChannel) -> Self {
        let ValueChannel { name, unit, range, tolerance, is_exact } = channel.clone();
        let channel = Some(value_channel(&name));
        let range = (range[0] < range[1]).then_some(range);
        let exact = (!is_exact).then_some(false);
        Self { name, unit, range, tolerance: Some(tolerance), exact, channel }
    }
}
