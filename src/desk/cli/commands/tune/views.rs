//! `overlook tune --fewest-views`: the views that are needed, what each adds, and what fewer give.

use std::fmt::Write;
use std::path::Path;

use super::TuneArgs;
use crate::cli::output::{self, CommandError, ViewsDocument};
use overlook_engine::capture::Capture;
use overlook_engine::error::Error;
use overlook_engine::settings::Settings;
use overlook_engine::whole_file;
use overlook_lab::chart;
use overlook_lab::truth::Truth;
use overlook_lab::tune::{self, ChosenViews};

/// Names of the chosen views, one a line.
const NAMES: &str = "views.txt";

impl TuneArgs {
    /// Chooses views, and writes the results to a folder.
    pub(super) fn choose_views(
        &self,
        folder: &Path,
        settings: &Settings,
        capture: &Capture,
        truth: &Truth,
    ) -> Result<(), CommandError> {
        std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        let shown = self.show_percent.map_or(tune::SHOWN_AT_LEAST, |percent| percent / 100.0);
        let chosen = output::watched(|job| tune::choose_views(capture, settings, shown, truth, job))?;
        let chart = chart::views(&capture.name, &chosen);
        let names = chosen.names().fold(String::new(), |names, name| names + name + "\n");
        let document = ViewsDocument {
            capture: capture.name.clone(),
            truth: truth_in_words(&chosen),
            command: output::command(),
            version: output::version(),
            chosen,
        };
        output::write_results(folder, "views", &document, &document.chosen.order, "views.png", &chart)?;
        whole_file::write_all(&folder.join(NAMES), names)?;
        output::write_page(&[folder.to_path_buf()], &folder.join(output::PAGE))?;
        if self.json {
            return output::print_json(&document);
        }
        output::print(&format!("{}\n{}", table(&document.chosen), document.chosen.words.join("\n")))
    }
}

fn truth_in_words(chosen: &ChosenViews) -> String {
    match (chosen.accuracy.is_empty(), chosen.left_out.is_empty()) {
        (true, _) => "none".to_owned(),
        (false, true) => "the capture's own views".to_owned(),
        (false, false) => "views that are left out".to_owned(),
    }
}

/// A line for each needed view, with the accuracy of that many views if it was measured; then a line for all views.
fn table(chosen: &ChosenViews) -> String {
    let mut text =
        format!("{:>6} {:>8} {:>8} {:>16} {:>10}  view", "views", "adds %", "shown %", "dB ± SE", "bytes");
    let accuracy = |views: usize| {
        let found = chosen.accuracy.iter().find(|count| count.views == views);
        found.map_or_else(
            || format!("{:>16} {:>10}", "", ""),
            |count| {
                let bytes = output::bytes(count.bytes);
                format!("{:>9.2} ± {:>4.2} {bytes:>10}", count.psnr_filled_db, count.psnr_filled_db_se)
            },
        )
    };
    for (index, view) in chosen.order[..chosen.needed].iter().enumerate() {
        let (adds, shown) = (100.0 * view.adds, 100.0 * view.shown);
        let accuracy = accuracy(index + 1);
        let _ = write!(text, "\n{:>6} {adds:>8.2} {shown:>8.2} {accuracy}  {}", index + 1, view.name);
    }
    if let Some(all) = chosen.accuracy.last().filter(|count| count.views > chosen.needed) {
        let views = all.views;
        let _ = write!(text, "\n{views:>6} {:>8} {:>8.2} {}", "", 100.0 * all.shown, accuracy(views));
    }
    text + "\n"
}
