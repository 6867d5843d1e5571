//! The small figures of RESULTS.md are made again and compared.

use std::fmt::Write;
use std::path::Path;

use overlook_engine::job::Job;
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::sweep::{self, Series, SweepPlan};
use overlook_lab::truth::Truth;

use super::small_capture;

/// What `overlook sweep assets/small_capture --vary render.kernel=gather --out small` measures with
/// the kernel `gather` and with the paper's settings, as RESULTS.md shows it.
fn small_table() -> String {
    let capture = small_capture::capture();
    let truth = Truth::Views(small_capture::views());
    let settings = Settings::default();
    let mut plan = SweepPlan::grid(&settings, &[], &capture).unwrap();
    plan.trials.retain(|planned| {
        // Rivals are rendered by no kernel.
        !planned.series.is_rival()
            && (planned.trial.settings.render.kernel == Kernel::Gather || planned.series == Series::Paper)
    });
    let points = sweep::run(&capture, &plan, &truth, &Job::new(), |_, _| ()).unwrap();
    let mut table = String::new();
    for point in points {
        let _ = writeln!(
            table,
            "| {} | {:.2} ± {:.2} | {:.2} | {:.3} | {:.3} | {:.3} | {} |",
            point.label,
            point.psnr_filled_db,
            point.psnr_filled_db_se,
            point.psnr_db,
            point.ssim,
            point.flip,
            point.coverage,
            point.samples
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
