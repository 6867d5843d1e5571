//! `overlook edit`: a store without what an edit list deletes.

use std::path::PathBuf;

use clap::Args;

use crate::cli::input;
use crate::cli::output::{self, CommandError};
use overlook_engine::edited_store::write_edited_store;
use overlook_engine::edits::EditList;
use overlook_engine::settings::CaptureSettings;
use overlook_engine::store::file::Store;

#[derive(Debug, Args)]
pub(crate) struct EditArgs {
    /// The store.
    store: PathBuf,
    /// The edit list (TOML, as the window saves it).
    #[arg(long, value_name = "FILE")]
    edits: PathBuf,
    /// The store to write. It may be the same file: that is replaced when the new one is whole.
    #[arg(long, value_name = "F.ovl")]
    out: PathBuf,
    /// The capture that the store was made from: its cameras say which samples they confirm, where an edit asks that.
    #[arg(long, value_name = "CAPTURE")]
    capture: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl EditArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        output::check_file(&self.out, "cleaned.ovl")?;
        output::refuse_input(&self.edits, &self.out)?;
        let edits = EditList::load(&self.edits)?;
        let store = Store::open(&self.store)?;
        output::warn(&store.info().warnings);
        let open = |path: &PathBuf| input::open_capture(path, &CaptureSettings::default());
        let capture = self.capture.as_ref().map(open).transpose()?;
        let before = (store.info().sample_count(), store.info().bytes);
        let (bytes, dropped) =
            output::watched(|job| write_edited_store(&self.out, &store, &edits, capture.as_ref(), job))?;
        if self.json {
            return output::print_json(&serde_json::json!({
                "samples_before": before.0,
                "samples_deleted": dropped,
                "bytes_before": before.1,
                "bytes_store": bytes,
            }));
        }
        output::print(&format!(
            "Deleted {} of {} ({}); wrote {} to {}, {} before",
            output::count(dropped),
            output::count_of(before.0, "sample"),
            output::percent(dropped, before.0),
            output::bytes(bytes),
            self.out.display(),
            output::bytes(before.1)
        ))
    }
}
