//! `overlook report`: one page on sweeps and stress tests of any number of captures.

use std::path::PathBuf;

use clap::Args;

use crate::cli::output::{self, CommandError};
use overlook_engine::plural::counted;

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Folders that `overlook sweep` and `overlook stress` wrote to, or folders of such.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// The page [default: report.html in the first folder].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl ReportArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let out = self.out.unwrap_or_else(|| self.folders[0].join(output::PAGE));
        output::check_file(&out, "report.html")?;
        let captures = output::write_page(&self.folders, &out)?;
        output::print(&format!("{}: {}", out.display(), counted(captures, "capture")))
    }
}
