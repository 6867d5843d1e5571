//! The small figures of RESULTS.md are made again and compared.

use std::fmt::Write;
use std::path::Path;

use overlook::capture::transforms::{open, open_views};
use overlook::evaluate::sweep::{self, Plan};
use overlook::evaluate::truth::Truth;
use overlook::job::Job;
use overlook::settings::{CaptureSettings, Settings};

/// What `overlook sweep assets/small_capture --vary render.kernel=gather,block --out small` measures, as RESULTS.md shows
/// it.
fn small_table() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture");
    let capture = open(&folder, &CaptureSettings::default()).unwrap();
    let truth = Truth::Views(open_views(&folder.join("novel/transforms.json")).unwrap());
    let axes = [("render.kernel".to_owned(), vec!["gather".to_owned(), "block".to_owned()])];
    let plan = Plan::grid(&Settings::default(), &axes, &capture).unwrap();
    let points = sweep::run(&capture, &plan, &truth, &Job::new(), |_, _| ()).unwrap();
    let mut table = String::new();
    for point in points {
        let _ = writeln!(
            table,
            "| {} | {:.2} ± {:.2} | {:.2} | {:.3} | {:.3} | {:.3} | {} | {:.0} |",
            point.label,
            point.psnr_filled_db,
            point.psnr_filled_db_se,
            point.psnr_db,
            point.ssim,
            point.flip,
            point.coverage,
            point.samples,
            point.bytes as f64 / 1024.0
        );
    }
    table
}

#[test]
fn the_small_figures_of_the_results_page_are_what_the_program_measures() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("RESULTS.md")).unwrap();
    let table = small_table();
    for row in table.lines() {
        assert!(page.contains(row), "RESULTS.md lacks\n{row}\nof\n{table}");
    }
}
