//! Pictures that are left out, counted by their reason.

use serde::Serialize;

/// Pictures that are not read, for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// How many.
    pub count: usize,
    /// Why.
    pub reason: String,
    /// The first of them.
    pub first: String,
}

impl Skipped {
    /// Notes one more picture that is left out.
    pub(crate) fn note(all: &mut Vec<Self>, reason: impl Into<String>, name: impl Into<String>) {
        let reason = reason.into();
        match all.iter_mut().find(|skipped| skipped.reason == reason) {
            Some(skipped) => skipped.count += 1,
            None => all.push(Self { count: 1, reason, first: name.into() }),
        }
    }

    /// In words.
    #[must_use]
    pub fn line(&self) -> String {
        format!("left out: {} {} (first: {})", self.count, self.reason, self.first)
    }
}
