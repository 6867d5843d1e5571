//! What was chosen and what was given up, in words.

use super::plan::{TuneBudget, TunePlan, Tuned};
use crate::sweep::Point;
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::Settings;

/// One sentence each.
pub(super) fn of(tuned: &Tuned, plan: &TunePlan, frames: usize) -> Vec<String> {
    let mut words = vec![good_enough(tuned, plan)];
    if tuned.cannot_tell {
        let vantages = tuned.best.vantages;
        words.push(format!(
            "{} {} too few to tell simpler settings from worse ones: the settings stay as they were.",
            counted(vantages, "viewpoint"),
            either(vantages, "is", "are")
        ));
    }
    words.push(chosen(tuned));
    words.extend(changes(&plan.settings, &tuned.settings));
    words.extend(tuned.bytes_whole.map(|bytes| {
        format!("The store of the whole capture takes {} at most with these settings.", megabytes(bytes))
    }));
    words.push(over_time(&tuned.chosen, frames));
    words.extend(cameras(tuned));
    words
}

fn megabytes(bytes: u64) -> String {
    let kilobytes = bytes as f64 / 1e3;
    if kilobytes < 1e3 { format!("{kilobytes:.1} kB") } else { format!("{:.2} MB", kilobytes / 1e3) }
}

fn good_enough(tuned: &Tuned, plan: &TunePlan) -> String {
    let Point { label, psnr_filled_db, .. } = &tuned.best;
    let tried = tuned.points.len();
    let settings = counted(tried, "setting");
    match (tuned.at_most_db, plan.budget) {
        (Some(at_most_db), _) => format!(
            "Of {settings} tried, '{label}' comes closest to the truth: {psnr_filled_db:.2} dB over {}. Good enough \
             is what gives up at most {at_most_db} dB of that with 95 % confidence, by the differences at each viewpoint.",
            counted(tuned.best.vantages, "viewpoint")
        ),
        (None, Some(TuneBudget::Milliseconds(milliseconds))) => {
            format!("Of {settings} tried, the most accurate within {milliseconds} ms was taken.")
        }
        (None, Some(TuneBudget::Bytes(bytes))) => {
            format!("Of {settings} tried, the most accurate within {} was taken.", megabytes(bytes))
        }
        (None, None) => format!("{settings} {} tried.", either(tried, "was", "were")),
    }
}

fn chosen(tuned: &Tuned) -> String {
    let (chosen, best) = (&tuned.chosen, &tuned.best);
    let share = 100.0 * chosen.bytes as f64 / best.bytes.max(1) as f64;
    format!(
        "Chosen: '{}' with {:.2} dB in {}; it gives up {:.2} dB of the best and takes {share:.0} % of its bytes.",
        chosen.label,
        chosen.psnr_filled_db,
        megabytes(chosen.bytes),
        (best.psnr_filled_db - chosen.psnr_filled_db).max(0.0),
    )
}

fn changes(before: &Settings, after: &Settings) -> Vec<String> {
    let changed: Vec<String> = Settings::fields()
        .filter_map(|field| {
            let (old, new) = (before.get(field.path)?, after.get(field.path)?);
            (old != new)
                .then(|| format!("{} = {} instead of {}.", field.path, shortest(&new), shortest(&old)))
        })
        .collect();
    if changed.is_empty() { vec!["No setting needs to change.".to_owned()] } else { changed }
}

/// Settings are single floats: their shortest form, not that of the double beside it.
fn shortest(value: &toml::Value) -> String {
    value.as_float().map_or_else(|| value.to_string(), |number| (number as f32).to_string())
}

fn over_time(point: &Point, frames: usize) -> String {
    let share = 100.0 * point.samples_shared as f64 / point.samples.max(1) as f64;
    match (point.samples_shared, point.spans) {
        _ if frames < 2 => "There is a single frame; nothing can be shared over time.".to_owned(),
        (shared, 1) if shared == point.samples => {
            "Nothing moves: a single span holds the whole scene.".to_owned()
        }
        (0, _) => "Nothing stays the same from frame to frame: every frame is kept for itself.".to_owned(),
        (_, spans) => {
            format!(
                "{share:.0} % of the samples serve more than one frame, in {} of {}.",
                counted(spans, "span"),
                counted(frames, "frame")
            )
        }
    }
}

fn cameras(tuned: &Tuned) -> Vec<String> {
    let Some(at_most_db) = tuned.at_most_db else { return Vec::new() };
    let mut words: Vec<String> = tuned
        .camera_costs
        .iter()
        .filter(|cost| cost.dropped)
        .map(|cost| {
            format!(
                "Camera '{}' can go: without it the accuracy is {:.2} dB, and {at_most_db} dB may be given up.",
                cost.name, cost.psnr_filled_db
            )
        })
        .collect();
    let needed = tuned.camera_costs.iter().filter(|cost| !cost.dropped);
    if let Some(next) = needed.max_by(|a, b| a.psnr_filled_db.total_cmp(&b.psnr_filled_db)) {
        words.push(format!(
            "No {}camera can go: without '{}' it is {:.2} dB.",
            if words.is_empty() { "" } else { "other " },
            next.name,
            next.psnr_filled_db
        ));
    }
    words
}
