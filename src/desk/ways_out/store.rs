//! The store of all kept samples.

use super::shared::{Action, FileKind, Size, WayOut};
use crate::text::{count_of, significant};

pub(crate) const WAY: WayOut = WayOut {
    name: "Store",
    used: "All kept samples in one file that Overlook opens at once, on any machine and without the recording.",
    button: "Save the store…",
    command: "store",
    about: "The store again, with another precision or coding",
    kind: |_| &STORE,
    size: |scope, _| {
        Size::about(scope.facts.store_bytes, samples_of(scope.facts.samples, scope.facts.store_bytes))
    },
    write: None,
};

/// A store.
pub(crate) const STORE: FileKind =
    FileKind { action: Action::Save, ..FileKind::of_samples("Save the store", &["ovl"], "") };

/// So many samples, and what each takes of some bytes.
pub(super) fn samples_of(samples: u64, bytes: f64) -> String {
    format!("{} of {} B", count_of(samples, "sample"), significant(bytes / samples.max(1) as f64))
}
