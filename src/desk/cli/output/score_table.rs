//! Tables of scores.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::text;
use overlook_lab::metrics::Scores;
use overlook_lab::{Evaluation, MeanScore, MethodComparison, PictureScores};

/// Columns of accuracy with their decimals. `PSNR dB` is over pixels that got a sample, `all dB` over all; `edge` is the error
/// near silhouettes, 8-bit steps.
const ACCURACY: [(&str, usize); 7] =
    [("PSNR dB", 2), ("all dB", 2), ("SSIM", 4), ("MS-SSIM", 4), ("FLIP", 4), ("edge", 2), ("cover", 3)];

fn accuracy_head() -> String {
    ACCURACY.iter().fold(String::new(), |mut text, (name, _)| {
        let _ = write!(text, " {name:>8}");
        text
    })
}

fn accuracy_columns(values: [Option<f64>; ACCURACY.len()]) -> String {
    let columns = values.iter().zip(ACCURACY);
    columns.fold(String::new(), |mut text, (value, (_, decimals))| {
        let _ = write!(text, " {}", text::number(*value, decimals, 8));
        text
    })
}

fn of_view(scores: &Scores) -> [Option<f64>; ACCURACY.len()] {
    let s = scores;
    let [psnr, all, ssim, ms_ssim, flip, cover] =
        [s.psnr_db, s.psnr_all_db, s.ssim, s.ms_ssim, s.flip, s.coverage].map(Some);
    [psnr, all, ssim, ms_ssim, flip, s.silhouette_steps, cover]
}

fn of_mean(mean: &MeanScore) -> [Option<f64>; ACCURACY.len()] {
    let m = mean;
    [m.psnr_db, m.psnr_all_db, m.ssim, m.ms_ssim, m.flip, m.silhouette_steps, m.coverage]
}

/// One line per view, then the mean.
pub(crate) fn view_table(evaluation: &Evaluation) -> String {
    let mut text = format!("{:<28}{} {:>10} {:>12}", "view", accuracy_head(), "ms", "samples");
    let mut line = |name: &str, values, milliseconds, samples| {
        let samples = text::count(samples);
        let _ = write!(text, "\n{name:<28}{} {milliseconds:>10.1} {samples:>12}", accuracy_columns(values));
    };
    for view in &evaluation.views {
        let values = view.scores.as_ref().map_or([None; ACCURACY.len()], of_view);
        line(&view.file_path, values, view.milliseconds, view.samples);
    }
    let mean = &evaluation.mean;
    line("mean", of_mean(mean), mean.milliseconds, mean.samples as u64);
    if let Some(psnr) = mean.psnr_aligned_db {
        let _ = write!(
            text,
            "\nViews aligned by their own pictures, at their own exposure: {psnr:.2} dB over pixels that got a sample"
        );
    }
    if let Some(steps) = mean.flicker_steps {
        let _ = write!(text, "\nFlicker at still viewpoints: {steps:.2} 8-bit steps");
    }
    text
}

/// A line on the shares of the error by place; empty if they are not known.
pub(crate) fn class_line(evaluation: &Evaluation) -> String {
    let Some(error) = &evaluation.mean.error_by_class else { return String::new() };
    let classes = [("unseen", error.unseen), ("edge", error.edge), ("inner", error.inner)];
    let words = classes.map(|(name, score)| {
        let psnr = score.psnr_db.map_or_else(|| "no pixel".to_owned(), |psnr| format!("{psnr:.2} dB"));
        format!(
            "{name} {psnr}, {:.1} % of the error on {:.1} % of the pixels",
            100.0 * score.of_error,
            100.0 * score.share
        )
    });
    format!("\nWhere surfaces are wrong: {}", words.join("; "))
}

/// The line that names what rendered.
pub(crate) fn painter_line(evaluation: &Evaluation) -> String {
    let painters: BTreeSet<String> = evaluation.views.iter().map(|view| view.painter.to_string()).collect();
    format!("Rendered by {}", painters.into_iter().collect::<Vec<_>>().join(" and "))
}

/// One line for each program whose pictures were scored, after an empty line and a heading; empty without such a program.
pub(crate) fn picture_table(programs: &[PictureScores]) -> String {
    let mut text = String::new();
    if !programs.is_empty() {
        let _ = write!(
            text,
            "\n\n{:<28} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}  matched by",
            "pictures of", "PSNR dB", "all dB", "SSIM", "FLIP", "cover", "flicker"
        );
    }
    for program in programs {
        let values = [
            (program.psnr_db, 2),
            (program.psnr_all_db, 2),
            (program.ssim, 4),
            (program.flip, 4),
            (program.coverage, 3),
            (program.flicker_steps, 2),
        ];
        let _ = write!(text, "\n{:<28}", program.name);
        for (value, decimals) in values {
            let _ = write!(text, " {}", text::number(value, decimals, 8));
        }
        let _ = write!(text, "  {}", program.matched_by);
    }
    text
}

/// One line per pruning method.
pub(crate) fn comparison_table(comparison: &MethodComparison) -> String {
    let head = accuracy_head();
    let mut text = format!("pruning         {head}         ms   samples kept    in memory in the store");
    for compared in [&comparison.as_set, &comparison.no_pruning, &comparison.first_camera] {
        let (method, mean) = (compared.method.name(), &compared.evaluation.mean);
        let (accuracy, milliseconds) = (accuracy_columns(of_mean(mean)), mean.milliseconds);
        let kept = text::count(compared.samples_kept);
        let [memory, store] = [compared.bytes_memory, compared.bytes_store].map(text::bytes);
        let _ =
            write!(text, "\n{method:<16}{accuracy} {milliseconds:>10.1} {kept:>14} {memory:>12} {store:>12}");
    }
    text
}
