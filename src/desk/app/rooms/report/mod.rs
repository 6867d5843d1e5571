//! The report: what was dropped and why, by rule, pair of cameras and memory.

mod control;
pub(crate) mod ui;
pub(crate) mod work;

use crate::app::model::picture::PixelSource;
use crate::app::model::purpose::{Table, TableForm};
use crate::app::model::scene::CameraMemory;
use crate::app::model::setting_names::SettingPairs;
use crate::app::model::state::State;
use crate::app::rooms::pixel::{own_sample, sees};
use crate::text::{account_parts, significant};
use overlook_engine::alignment::AlignedCamera;
use overlook_engine::capture::Camera;
use overlook_engine::preprocess::diagnostics::{CameraReport, Report, SpanReport};
use overlook_engine::preprocess::inspect::CameraEvidence;
use overlook_engine::settings::Settings;
use overlook_lab::stress::StressPoint;
use overlook_lab::sweep::Point;

/// The table of the known values; `None` while there are none.
pub(crate) fn table_text(table: Table, form: TableForm, state: &State) -> Option<String> {
    let charts = &state.doc.charts;
    let rows = match table {
        Table::Sweep => charts.sweep.iter().map(sweep_row).collect(),
        Table::StressTest => charts.stress.iter().map(stress_row).collect(),
        Table::Replacements => replacements(state.report()?),
        Table::Agreement => agreement(state.report()?),
        Table::Alignment => alignment(state.report()?),
        Table::Pixel => pixel(state)?,
        Table::Cameras => cameras(state.report()?),
        Table::Pixels => pixels(state.report()?),
        Table::Memory => memory(state)?,
        Table::Spans => state.report()?.spans.iter().map(span).collect(),
    };
    (!rows.is_empty()).then(|| match form {
        TableForm::Csv => as_csv(&rows),
        TableForm::Markdown => format!("{}\n{}\n", as_markdown(&rows), made_with(state)),
        TableForm::Latex => format!("{}% {}\n", as_latex(&rows), made_with(state)),
    })
}

/// The version of the program and the settings that are not the defaults, in a line.
fn made_with(state: &State) -> String {
    let defaults = Settings::default();
    let pairs = SettingPairs::new(&state.settings, &defaults);
    let settings: Vec<String> =
        pairs.differing().map(|(field, [value, _])| format!("{} = {value}", field.path)).collect();
    let settings = if settings.is_empty() { "default settings".to_owned() } else { settings.join(", ") };
    let scene = state.doc.scene.as_ref().map_or("", |scene| scene.name.as_str());
    format!("{scene}: Overlook {}, {settings}", env!("CARGO_PKG_VERSION"))
}

/// Whether a cell is a number, and how it reads in a text.
fn readable(cell: &str) -> (bool, String) {
    match cell.parse::<f64>() {
        Ok(number) if cell.contains('.') && number.is_finite() => (true, significant(number)),
        Ok(_) => (true, cell.to_owned()),
        Err(_) => (false, cell.to_owned()),
    }
}

/// The line of names, and those of cells, with what stands before, between and after the texts of a line.
fn lines(rows: &[CsvRow], [start, between, end]: [&str; 3], text: impl Fn(&str) -> String) -> [String; 2] {
    let line = |texts: Vec<String>| format!("{start}{}{end}", texts.join(between));
    let names = rows.iter().take(1).map(|row| line(row.iter().map(|(name, _)| text(name)).collect()));
    let cells = rows.iter().map(|row| line(row.iter().map(|(_, cell)| text(cell)).collect()));
    [names.collect(), cells.collect()]
}

/// A mark for each column: one for numbers, or one for words.
fn marks<'a>(rows: &[CsvRow], [number, word]: [&'a str; 2]) -> Vec<&'a str> {
    let is_number = |nth: usize| rows.iter().all(|row| row.get(nth).is_none_or(|(_, cell)| readable(cell).0));
    (0..rows.first().map_or(0, Vec::len)).map(|nth| if is_number(nth) { number } else { word }).collect()
}

fn as_csv(rows: &[CsvRow]) -> String {
    lines(rows, ["", ",", "\r\n"], quoted).concat()
}

fn as_markdown(rows: &[CsvRow]) -> String {
    let escaped = |text: &str| readable(text).1.replace('|', "\\|").replace(['\n', '\r'], " ");
    let [names, cells] = lines(rows, ["| ", " | ", " |\n"], escaped);
    let alignment = marks(rows, ["---:", "---"]).join(" | ");
    format!("{}| {alignment} |\n{cells}", names.replace('_', " "))
}

fn as_latex(rows: &[CsvRow]) -> String {
    let [names, cells] = lines(rows, ["  ", " & ", " \\\\\n"], |text| latex(&readable(text).1));
    let (names, alignment) = (names.replace("\\_", " "), marks(rows, ["r", "l"]).concat());
    format!(
        "\\begin{{tabular}}{{{alignment}}}\n  \\hline\n{names}  \\hline\n{cells}  \\hline\n\\end{{tabular}}\n"
    )
}

/// Text that LaTeX prints as it is.
fn latex(text: &str) -> String {
    text.chars().fold(String::new(), |mut out, letter| {
        match letter {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', letter]),
            '~' => out += "\\textasciitilde{}",
            '^' => out += "\\textasciicircum{}",
            '\\' => out += "\\textbackslash{}",
            '−' => out += "$-$",
            '\n' | '\r' => out.push(' '),
            _ => out.push(letter),
        }
        out
    })
}

fn pixels(report: &Report) -> Vec<CsvRow> {
    let account = report.pixel_account();
    let parts = account_parts(&account).into_iter().chain([("all", account.pixels)]);
    let row = |(name, pixels): (&str, u64)| {
        let percent = 100.0 * pixels as f64 / account.pixels.max(1) as f64;
        vec![
            ("became", name.to_owned()),
            ("pixels", pixels.to_string()),
            ("percent", format!("{percent:.4}")),
        ]
    };
    parts.map(row).collect()
}

/// A row: the name of each column, and its cell.
type CsvRow = Vec<(&'static str, String)>;

/// A cell in quotes where it needs them.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

fn sweep_row(point: &Point) -> CsvRow {
    vec![
        ("label", point.label.clone()),
        ("series", point.series.name().to_owned()),
        ("kernel", point.settings.render.kernel.name().to_owned()),
        ("psnr_filled_db", point.psnr_filled_db.to_string()),
        ("psnr_filled_db_se", point.psnr_filled_db_se.to_string()),
        ("ssim", point.ssim.to_string()),
        ("flip", point.flip.to_string()),
        ("coverage", point.coverage.to_string()),
        ("samples", point.samples.to_string()),
        ("bytes", point.bytes.to_string()),
        ("bytes_memory", point.bytes_memory.to_string()),
        ("milliseconds", point.milliseconds.to_string()),
        ("load_of_others", point.load_of_others.map_or_else(String::new, |load| load.to_string())),
        ("seconds_preprocess", point.seconds_preprocess.to_string()),
        ("pareto", point.pareto.to_string()),
    ]
}

fn stress_row(stressed: &StressPoint) -> CsvRow {
    let mut row = vec![
        ("disturbance", stressed.disturbance.clone()),
        ("size", stressed.dial.to_string()),
        ("unit", stressed.unit.clone()),
        ("method", stressed.method.clone()),
        ("loss_db", stressed.loss_db.to_string()),
    ];
    row.extend(sweep_row(&stressed.point));
    row
}

fn camera_name(report: &Report, index: usize) -> String {
    report.cameras.get(index).map_or_else(String::new, |camera| camera.name.clone())
}

fn replacements(report: &Report) -> Vec<CsvRow> {
    let name = |index| camera_name(report, index);
    let row = |(loser, winner, count): (usize, usize, &u64)| {
        vec![("camera", name(loser)), ("replaced_by", name(winner)), ("samples", count.to_string())]
    };
    report.witnesses.iter().filter(|(loser, winner, _)| loser != winner).map(row).collect()
}

fn alignment(report: &Report) -> Vec<CsvRow> {
    let row = |camera: &AlignedCamera| {
        let (pose, exposure) = (camera.pose.unwrap_or_default(), camera.exposure.unwrap_or_default());
        vec![
            ("camera", camera.name.clone()),
            ("degrees", pose.degrees.to_string()),
            ("degrees_se", pose.degrees_se.to_string()),
            ("distance", pose.distance.to_string()),
            ("distance_se", pose.distance_se.to_string()),
            ("footprints", pose.footprints.to_string()),
            ("red_stops", exposure.stops[0].to_string()),
            ("green_stops", exposure.stops[1].to_string()),
            ("blue_stops", exposure.stops[2].to_string()),
            ("frames_late", camera.clock.unwrap_or_default().frames.to_string()),
            ("pose_is_weak", camera.pose_is_weak.to_string()),
        ]
    };
    report.alignment.iter().flat_map(|alignment| &alignment.cameras).map(row).collect()
}

fn agreement(report: &Report) -> Vec<CsvRow> {
    let name = |index| camera_name(report, index);
    let mut rows = Vec::new();
    for (of, against, pair) in report.residuals.iter() {
        for (what, residual) in [("static", pair.lasting), ("moving", pair.moving)] {
            let Some(residual) = residual else { continue };
            rows.push(vec![
                ("camera", name(of)),
                ("against", name(against)),
                ("what", what.to_owned()),
                ("samples", residual.samples.to_string()),
                ("median_footprints", residual.median_footprints.to_string()),
                ("most_footprints", residual.most_footprints.to_string()),
                ("median_color_steps", residual.median_color_steps.to_string()),
            ]);
        }
    }
    rows
}

fn pixel(state: &State) -> Option<Vec<CsvRow>> {
    let scene = state.doc.scene.as_ref()?;
    let explanation = state.doc.probe.shown.as_ref()?.explanation.as_ref()?;
    let number = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
    let row = |row: &CameraEvidence| {
        vec![
            ("camera", scene.cameras.get(row.camera).map_or_else(String::new, |camera| camera.name.clone())),
            ("visible", sees(row).0.to_owned()),
            ("depth_expected", number(row.depth_expected)),
            ("depth_found", number(row.depth_found)),
            ("depth_error_footprints", number(row.plane_distance_footprints)),
            ("incidence_degrees", number(row.incidence_degrees)),
            ("paper_r", number(row.paper_r)),
            ("footprint_r", number(row.footprint_r)),
            ("color_difference_steps", number(row.color_difference_steps)),
            ("own_sample", own_sample(row).unwrap_or_default().plain(&scene.cameras)),
        ]
    };
    Some(explanation.evidence.iter().map(row).collect())
}

fn cameras(report: &Report) -> Vec<CsvRow> {
    let row = |camera: &CameraReport| {
        vec![
            ("camera", camera.name.clone()),
            ("pixels", camera.pixels.to_string()),
            ("kept", (camera.background_kept + camera.foreground_kept).to_string()),
            ("static_pixels", camera.background_pixels.to_string()),
            ("color_noise_steps", camera.color_noise_steps.to_string()),
            ("depth_noise_relative", camera.depth_noise_relative.to_string()),
        ]
    };
    report.cameras.iter().map(row).collect()
}

fn memory(state: &State) -> Option<Vec<CsvRow>> {
    let (cameras, taken) = (&state.doc.scene.as_ref()?.cameras, state.doc.memory.as_ref()?);
    let row = |(camera, taken): (&Camera, &CameraMemory)| {
        vec![
            ("camera", camera.name.clone()),
            ("samples", taken.samples.to_string()),
            ("bytes_of_several_frames", taken.lasting_bytes.to_string()),
            ("bytes_of_one_frame", taken.frame_bytes.to_string()),
            ("bytes", (taken.lasting_bytes + taken.frame_bytes).to_string()),
        ]
    };
    Some(cameras.iter().zip(taken).map(row).collect())
}

/// Frames are numbered from one, as in the window.
fn span(SpanReport { span, samples }: &SpanReport) -> CsvRow {
    vec![
        ("first_frame", (span.start + 1).to_string()),
        ("last_frame", span.end.to_string()),
        ("frames", span.len().to_string()),
        ("samples", samples.to_string()),
    ]
}

/// Bytes of a displayed color.
const COLOR: usize = 4;

/// Bytes of a rendered pixel: color, inverse depth, and the image that it comes from.
const RENDERED: usize = 20;

impl State {
    /// The parts that are largest, in bytes, and the whole program where the system tells.
    pub(crate) fn held_memory(&self) -> Vec<(&'static str, u64)> {
        let samples = self.whole_samples().map_or(0, |samples| samples.bytes());
        let decoded =
            self.doc.scene.as_ref().and_then(|scene| scene.playback()).map_or(0, |it| it.cached_bytes());
        let live = self.doc.live_shown.as_ref().map_or(0, |shown| match &shown.picture.pixels {
            PixelSource::InMemory { rendered, .. } => rendered.image.len() * (RENDERED + COLOR),
            PixelSource::OnAdapter(_) => 0,
        });
        let source =
            self.doc.source_shown.as_ref().map_or(0, |shown| shown.picture.image.pixels.len() * COLOR);
        let mut parts = vec![
            ("Samples", samples),
            ("Samples decoded from the store", decoded),
            ("Pictures shown", (live + source) as u64),
        ];
        parts.retain(|(_, bytes)| *bytes > 0);
        parts.extend(resident().map(|bytes| ("The whole program", bytes)));
        parts
    }
}

/// Bytes of the program that are in memory; `None` where the system does not tell.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_lab::sweep::Series;
    use overlook_lab::trial::{Trial, TrialResult};

    #[test]
    fn a_table_quotes_or_escapes_rounds_aligns_and_says_what_it_was_made_with_as_its_form_asks() {
        let mut state = State::default();
        assert_eq!(table_text(Table::Sweep, TableForm::Csv, &state), None);
        state.settings.pruning.depth_tolerance = 2.5;
        let trial = Trial::new("50 % of a_b | {c}, \"d\"", Settings::default());
        let mut point = Point::new(&trial, Series::Variation, &TrialResult::default());
        (point.milliseconds, point.load_of_others) = (12.345_678, Some(0.0));
        state.doc.charts.sweep.push(point);
        let text = |form| table_text(Table::Sweep, form, &state).unwrap();
        let csv = text(TableForm::Csv);
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!((lines.len(), lines[0].split(',').count()), (2, 15));
        assert!(lines[0].starts_with("label,series,kernel,psnr_filled_db,"), "{csv}");
        assert!(lines[1].starts_with("\"50 % of a_b | {c}, \"\"d\"\"\","), "{csv}");
        let markdown = text(TableForm::Markdown);
        let lines: Vec<&str> = markdown.lines().collect();
        assert!(lines[0].starts_with("| label | series | kernel | psnr filled db |"), "{markdown}");
        assert!(lines[1].starts_with("| --- | --- | --- | ---: |"), "{markdown}");
        assert!(
            lines[2].starts_with("| 50 % of a_b \\| {c}, \"d\" |") && lines[2].contains("| 12.3 |"),
            "{markdown}"
        );
        assert!(
            markdown.contains("Overlook ") && markdown.contains("pruning.depth_tolerance = 2.5"),
            "{markdown}"
        );
        let latex = text(TableForm::Latex);
        assert!(latex.starts_with("\\begin{tabular}{lllrrrrrrrrrrrl}"), "{latex}");
        assert!(
            latex.contains("  50 \\% of a\\_b | \\{c\\}, \"d\" & ") && latex.contains("\\end{tabular}\n% "),
            "{latex}"
        );
        let cells = |line: &str| line.matches(" & ").count();
        assert!(latex.lines().filter(|line| line.ends_with("\\\\")).all(|line| cells(line) == 14), "{latex}");
    }
}
