//! `overlook bench`: speed of each stage, and the limits of the machine.

use std::fmt::Write;

use clap::Args;

use crate::cli::input::choice;
use crate::cli::output::{self, CommandError};
use overlook_engine::plural::counted;
use overlook_engine::settings::{Backend, Instructions};
use overlook_lab::bench::{self, Limit, LimitKind, Machine, Options, SpeedReport, StageSpeed};

/// The names of [`Backend`], which for measuring do not exclude each other.
const BACKENDS: &[(&str, &str)] = &[
    ("auto", "The CPU, and a GPU where there is one."),
    ("cpu", "The CPU alone."),
    ("gpu", "The CPU and the GPU, or a software Vulkan driver."),
];

#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Measure only stages with PART in their name, as in render/point; may be given several times.
    #[arg(long, value_name = "PART")]
    only: Vec<String>,
    /// What is measured painting.
    #[arg(long, default_value = "auto", value_parser = choice::<Backend>(BACKENDS))]
    backend: Backend,
    /// The widest vector instructions that the stages may use; narrower ones give the same bits.
    #[arg(long, default_value = "auto", value_parser = choice::<Instructions>(Instructions::NAMES))]
    instructions: Instructions,
    /// Few repeats on a small scene: shows that everything works, not how fast it is.
    #[arg(long)]
    quick: bool,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl BenchArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let Self { only, backend, instructions, quick, json } = self;
        let options = Options { threads: rayon::current_num_threads(), quick, backend, instructions, only };
        let report = output::watched(|job| bench::measure(&options, job))?;
        if !report.machine.optimized {
            output::warn(&["this is not a release build; its times mean nothing".to_owned()]);
        }
        if json { output::print_json(&report) } else { output::print(&text(&report)) }
    }
}

fn text(report: &SpeedReport) -> String {
    let mut text = machine_line(&report.machine);
    let (samples, pruned) =
        (output::count_of(report.samples, "sample"), output::count(report.samples_pruned));
    let _ = write!(text, "\n{samples} of nine cameras, {pruned} after pruning");
    let _ = write!(text, "\n\n{:>7} {:>10} {:>12}", "threads", "read GB/s", "scatter M/s");
    for limit in &report.limits {
        let Limit { threads, read_gb_per_s, scatter_mpts_per_s, .. } = limit;
        let _ = write!(text, "\n{threads:>7} {read_gb_per_s:>10.1} {scatter_mpts_per_s:>12.0}");
    }
    if let Some(copy) = report.limits.last().and_then(|limit| limit.gpu_copy_gb_per_s) {
        let adapter = report.machine.adapter.as_deref().unwrap_or("the graphics adapter");
        let _ = write!(text, "\n{adapter} copies {copy:.1} GB/s of its memory");
    }
    let _ = write!(
        text,
        "\n\n{:<44} {:>7} {:>10} {:>8} {:>9} {:>18} {:>7} {:>7}",
        "stage", "threads", "median ms", "± ms", "M/s", "of limit", "cover", "repeats"
    );
    for stage in &report.stages {
        stage_lines(&mut text, stage);
    }
    text
}

fn machine_line(machine: &Machine) -> String {
    let Machine { cpu, os, arch, threads_available, instructions, .. } = machine;
    let cpu = cpu.as_deref().unwrap_or("unknown CPU");
    format!(
        "{cpu} ({os} {arch}), {}; stages use {instructions} instructions",
        counted(*threads_available, "thread")
    )
}

fn stage_lines(text: &mut String, stage: &StageSpeed) {
    let limit = match stage.limit {
        LimitKind::Scatter => "scatter",
        LimitKind::Read => "read",
        LimitKind::Copy => "copy",
    };
    let StageSpeed { name, threads, median_ms, spread_ms, mpts_per_s, repeats, painting, .. } = stage;
    let percent = 100.0 * stage.fraction_of_limit;
    let coverage = output::number(painting.as_ref().map(|painting| painting.coverage), 4, 7);
    let _ = write!(
        text,
        "\n{name:<44} {threads:>7} {median_ms:>10.2} {spread_ms:>8.2} {mpts_per_s:>9.1} {percent:>10.2} % {limit:<7} \
         {coverage} {repeats:>5}"
    );
    if let Some(speedup) = painting.as_ref().and_then(|painting| painting.speedup_over_full_repaint) {
        let _ = write!(text, "   {speedup:.1} × faster than rendering everything again");
    }
    if let Some(stages) = painting.as_ref().and_then(|painting| painting.stages) {
        let parts = stages.parts().map(|(name, ms)| format!("{name} {ms:.1}"));
        let cpu = stage.cpu_ms.map(|ms| format!("{ms:.1} ms of processor time; ")).unwrap_or_default();
        let _ = write!(text, "\n    {cpu}ms a stage: {}", parts.join(", "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_backend_can_be_measured() {
        assert!(BACKENDS.iter().map(|(name, _)| name).eq(Backend::NAMES.iter().map(|(name, _)| name)));
    }
}
