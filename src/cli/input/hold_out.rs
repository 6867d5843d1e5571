//! The option of `preprocess` and `evaluate` to leave cameras out.

use std::collections::HashSet;

use clap::Args;

/// Which cameras are left out.
#[derive(Debug, Args)]
pub(crate) struct HoldOutArgs {
    /// Leave this camera out, so that pictures can be scored against its frames; may be given several times.
    #[arg(long, value_name = "CAMERA")]
    hold_out: Vec<String>,
}

impl HoldOutArgs {
    /// Their names in the order given, each once.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names = self.hold_out.clone();
        let mut seen = HashSet::new();
        names.retain(|name| seen.insert(name.clone()));
        names
    }
}
