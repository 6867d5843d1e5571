//! The parts of the page.

use std::fmt::Write;

use super::markup::{embedded, figure, table};
use super::results::CaptureResults;
use super::together::{Overall, reference};
use crate::chart;
use crate::metrics::ClassScore;
use crate::stress::LOST_DB;
use crate::sweep::{Point, Series, mark_pareto_of_stores};
use crate::tune::{ChosenViews, ViewCount};
use overlook_engine::page::escaped;
use overlook_engine::plural::{counted, either};

/// Settings that a table of one capture shows besides rivals and baselines, the most accurate first.
const SHOWN_SETTINGS: usize = 12;

/// Settings that the table of all captures shows besides rivals and baselines.
const SHOWN_TOGETHER: usize = 15;

/// All captures together: which settings win, and by how much.
pub(super) fn together(rows: &[Overall], captures: usize) -> String {
    let (ours, others): (Vec<&Overall>, Vec<&Overall>) =
        rows.iter().partition(|row| matches!(row.series, Series::Reference | Series::Variation));
    let mut shown: Vec<&Overall> = ours.iter().copied().take(SHOWN_TOGETHER).collect();
    shown.extend(ours.iter().copied().skip(SHOWN_TOGETHER).filter(|row| row.series == Series::Reference));
    shown.extend(others);
    let cells = |row: &&Overall| {
        vec![
            name(&row.label, row.series),
            format!("{:.1}", row.rank),
            format!("{:+.2} ± {:.2}", row.ahead_db.mean, row.ahead_db.standard_error),
            format!("{:+.2} ({})", row.least.0, escaped(&row.least.1)),
            format!("{:.2}", row.bytes),
            format!("{:.2}", row.milliseconds),
        ]
    };
    let head = ["setting or method", "mean rank", "dB ahead of the default", "least", "× bytes", "× ms"];
    let lines: Vec<_> = shown.iter().map(cells).collect();
    format!(
        "<h2 id=\"together\">All {captures} captures together</h2>\n<p>For each capture a setting is compared with the default at the same \
         viewpoints; the mean over captures is shown with its standard error ({}), the capture where it does worst, and \
         geometric means of bytes and milliseconds as shares of the default's. Ranks are among the {} that were \
         measured on all captures.</p>\n{}{}",
        counted(captures - 1, "degree") + " of freedom",
        counted(rows.len(), "setting") + " and methods",
        embedded(&chart::together(&shown.iter().map(|row| together_point(row)).collect::<Vec<_>>()).svg()),
        table(&head, &lines)
    )
}

fn together_point(row: &Overall) -> chart::TogetherPoint {
    chart::TogetherPoint {
        label: row.label.clone(),
        series: row.series,
        bytes: row.bytes,
        ahead_db: row.ahead_db,
    }
}

/// One capture: charts, tables, pictures.
pub(super) fn capture(results: &CaptureResults, id: &str) -> String {
    let mut html = format!(
        "<section><h2 id=\"{id}\">{}</h2>\n<p>Truth: {}.</p>\n",
        escaped(&results.name),
        escaped(&results.truth)
    );
    if !results.points.is_empty() {
        html += &sweep(results);
    }
    if !results.stress.is_empty() {
        html += &stress(results);
    }
    if let Some(chosen) = &results.views {
        html += &views(&results.name, chosen);
    }
    html + "</section>\n"
}

fn sweep(results: &CaptureResults) -> String {
    let points = &results.points;
    let mut html = String::from("<h3>Accuracy, size and speed</h3>\n");
    html += &embedded(&chart::pareto(&results.name, points).svg());
    let _ = writeln!(html, "<p>{}</p>", escaped(&verdict(points)));
    let mut ours: Vec<&Point> =
        points.iter().filter(|point| matches!(point.series, Series::Reference | Series::Variation)).collect();
    ours.sort_by(|a, b| b.psnr_filled_db.total_cmp(&a.psnr_filled_db));
    let left_out = ours.len().saturating_sub(SHOWN_SETTINGS);
    let mut shown: Vec<&Point> = ours.iter().copied().take(SHOWN_SETTINGS).collect();
    shown.extend(ours.iter().copied().skip(SHOWN_SETTINGS).filter(|point| point.series == Series::Reference));
    shown.extend(points.iter().filter(|point| point.series.is_baseline()));
    let head =
        ["setting or method", "dB", "behind the best", "SSIM", "FLIP", "unseen", "edge", "inner", "MB", "ms"];
    html += &table(&head, &shown.iter().map(|point| cells(point)).collect::<Vec<_>>());
    let _ = writeln!(
        html,
        "<p class=\"note\">dB: PSNR over all pixels that some camera saw, holes filled alike. Unseen, edge, inner: PSNR there, and the \
         share of the squared error. A star marks the Pareto front of bytes and dB, ~ a time that was taken while other programs used \
         more than a tenth of the machine. {left_out} less accurate settings are in sweep.csv.</p>"
    );
    if !results.worst.is_empty() {
        html += "<h3>Worst viewpoints of the default</h3>\n<p class=\"note\">The truth, the picture, and its error: bright at 64 8-bit \
                 steps; pink where no camera saw the surface, orange at edges, blue elsewhere.</p>\n";
        for worst in &results.worst {
            html += &figure(worst);
        }
    }
    html
}

/// Whether ours are on the front, in words.
fn verdict(points: &[Point]) -> String {
    let mut points = points.to_vec();
    mark_pareto_of_stores(&mut points);
    let is_ours = |point: &&Point| matches!(point.series, Series::Reference | Series::Variation);
    let front: Vec<&Point> = points.iter().filter(|point| point.pareto).collect();
    let others: Vec<&Point> = front.iter().copied().filter(|point| !is_ours(point)).collect();
    let count = front.len() - others.len();
    let best = points.iter().max_by(|a, b| a.psnr_filled_db.total_cmp(&b.psnr_filled_db));
    let leader = best.map_or_else(String::new, |best| format!("; the most accurate is '{}'", best.label));
    if others.is_empty() {
        return match count {
            1 => format!(
                "The one point on the Pareto front of bytes and accuracy is a setting of ours{leader}."
            ),
            _ => format!(
                "All {count} points on the Pareto front of bytes and accuracy are settings of ours{leader}."
            ),
        };
    }
    let named: Vec<String> = others
        .iter()
        .map(|point| {
            format!(
                "'{}' ({:.2} dB, {:.2} MB)",
                point.label,
                point.psnr_filled_db,
                point.megabytes_of_samples()
            )
        })
        .collect();
    let ours = match count {
        0 => "No point on the Pareto front of bytes and accuracy is a setting of ours".to_owned(),
        _ => format!(
            "{} on the Pareto front of bytes and accuracy {} ours",
            counted(count, "point"),
            either(count, "is a setting of", "are settings of")
        ),
    };
    let verb = if others.len() == 1 { "the other is" } else { "the others are" };
    format!("{ours}; {verb} {}{leader}.", named.join(", "))
}

fn name(label: &str, series: Series) -> String {
    let class = match series {
        Series::Reference => "default",
        series if series.is_baseline() => "other",
        _ => "",
    };
    format!("<span class=\"{class}\">{}</span>", escaped(label))
}

fn cells(point: &Point) -> Vec<String> {
    let class = |score: Option<ClassScore>| {
        score.map_or_else(String::new, |score| {
            let psnr = score.psnr_db.map_or_else(|| "–".to_owned(), |psnr| format!("{psnr:.1}"));
            format!("{psnr} ({:.0} %)", 100.0 * score.of_error)
        })
    };
    let star = if point.pareto { " ★" } else { "" };
    let scored = !point.views.is_empty();
    let number = |text: String| if scored { text } else { "–".to_owned() };
    vec![
        name(&point.label, point.series) + star,
        format!("{:.2}", point.psnr_filled_db),
        format!("{:.2} ± {:.2}", point.behind_best_db, point.behind_best_db_se),
        number(format!("{:.3}", point.ssim)),
        number(format!("{:.3}", point.flip)),
        class(point.error_by_class.map(|error| error.unseen)),
        class(point.error_by_class.map(|error| error.edge)),
        class(point.error_by_class.map(|error| error.inner)),
        format!("{:.2}", point.megabytes_of_samples()),
        point.milliseconds_text(),
    ]
}

fn stress(results: &CaptureResults) -> String {
    let mut html = format!(
        "<h3>Where methods break</h3>\n{}",
        embedded(&chart::stress(&results.name, &results.stress).svg())
    );
    let rows: Vec<Vec<String>> = results
        .failures
        .iter()
        .map(|failure| {
            let dial = failure.dial.map_or_else(|| "never".to_owned(), |dial| format!("{dial:.2}"));
            vec![
                escaped(&format!("{}, {}", failure.disturbance, failure.unit)),
                escaped(&failure.method),
                dial,
                format!("{:.2}", failure.worst_loss_db),
            ]
        })
        .collect();
    html +=
        &table(&["disturbance", "method", &format!("{LOST_DB} dB is lost at"), "largest loss, dB"], &rows);
    if !results.breaking.is_empty() {
        html += "<h3>What failure looks like</h3>\n<p class=\"note\">The truth, the picture, and its error, at the viewpoint where it is \
                 worst.</p>\n";
        for breaking in &results.breaking {
            html += &figure(breaking);
        }
    }
    html
}

/// The fewest views that show everything.
fn views(name: &str, chosen: &ChosenViews) -> String {
    let mut html = String::from("<h3>The fewest views</h3>\n");
    html += &embedded(&chart::views(name, chosen).svg());
    let _ = writeln!(html, "<p>{}</p>", escaped(&chosen.words.join(" ")));
    let cells = |count: &ViewCount| {
        vec![
            count.views.to_string(),
            format!("{:.1} %", 100.0 * count.shown),
            format!("{:.2} ± {:.2}", count.psnr_filled_db, count.psnr_filled_db_se),
            format!("{:.2}", count.bytes as f64 / 1e6),
        ]
    };
    if !chosen.accuracy.is_empty() {
        let rows: Vec<_> = chosen.accuracy.iter().map(cells).collect();
        html += &table(&["views", "shown", "dB", "MB"], &rows);
    }
    html
}

/// The settings that all sweeps started from, where they are the same.
pub(super) fn settings(captures: &[CaptureResults]) -> String {
    let mut texts: Vec<(String, Vec<&str>)> = Vec::new();
    for (capture, point) in captures.iter().filter_map(|capture| Some((capture, reference(capture)?))) {
        let text = toml::to_string(&point.settings).unwrap_or_default();
        match texts.iter_mut().find(|(known, _)| *known == text) {
            Some((_, names)) => names.push(&capture.name),
            None => texts.push((text, vec![&capture.name])),
        }
    }
    texts.iter().fold(String::new(), |mut html, (text, names)| {
        let _ = writeln!(html, "<h3>{}</h3><pre>{}</pre>", escaped(&names.join(", ")), escaped(text));
        html
    })
}
