//! `overlook export store`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::input::{SettingsArgs, StoreArgs};
use crate::cli::output::{self, CommandError};
use overlook_engine::error::Error;
use overlook_engine::store;

#[derive(Debug, Args)]
pub(crate) struct StoreAgainArgs {
    #[command(flatten)]
    from: StoreArgs,
    /// The store to write. It may be the same file: that is replaced when the new one is whole.
    #[arg(long, value_name = "F.ovl")]
    out: PathBuf,
    /// The settings of how it is stored, as in --set store.precision=bits10.
    #[command(flatten)]
    settings: SettingsArgs,
}

impl StoreAgainArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        self.settings.only("store")?;
        output::check_file(&self.out, "scene.ovl")?;
        self.settings.refuse_inputs(&self.out)?;
        self.from.edits.refuse_inputs(&self.out)?;
        let before =
            std::fs::metadata(&self.from.store).map_err(|error| Error::io(&self.from.store, error))?.len();
        let playback = self.from.open()?;
        let opened = playback.store();
        let settings = self.settings.over(opened.info().settings.clone())?;
        let bytes = output::watched(|job| store::write_again(&self.out, opened, Some(&settings.store), job))?;
        let [bytes, before] = [bytes, before].map(output::bytes);
        output::print(&format!("Wrote {bytes} to {}, {before} before", self.out.display()))
    }
}
