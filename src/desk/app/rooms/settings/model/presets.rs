//! Settings to start from: those that come along, and one's own.

use overlook_engine::settings::{Fill, Kernel, MixedPixels, PruningMethod, RateModel, Settings, SpanLevels};

/// Settings to start from.
type Preset = (&'static str, &'static str, fn(&mut Settings));

/// Settings to start from: name, purpose, and changes of the defaults.
pub(crate) const PRESETS: [Preset; 6] = [
    ("Balanced", "The defaults.", |_| {}),
    (
        "As in the paper",
        "Static or per-frame samples, the printed r, no overlap at depth edges, edge-blended pixels kept, 2×2 blending, holes left open.",
        |settings| {
            settings.spans.levels = SpanLevels::Paper;
            settings.pruning.rate = RateModel::Paper;
            settings.pruning.overlap = false;
            settings.pruning.mixed_pixels = MixedPixels::Keep;
            settings.render.kernel = Kernel::Block;
            settings.render.fill = Fill::None;
        },
    ),
    ("Conservative", "Drops only what agrees closely in depth, normal and color.", |settings| {
        settings.pruning.depth_tolerance = 0.5;
        settings.pruning.normal_tolerance = 15.0;
        settings.pruning.color_tolerance = 10.0;
        settings.spans.color_tolerance = 1.0;
    }),
    ("Aggressive", "Drops all that is nearly shown elsewhere: small files.", |settings| {
        settings.pruning.depth_tolerance = 2.5;
        settings.pruning.normal_tolerance = 50.0;
        settings.pruning.color_tolerance = 64.0;
        settings.spans.color_tolerance = 8.0;
        settings.pruning.overlap = false;
    }),
    (
        "First camera wins",
        "Keeps what a layered depth image keeps, without regard to sampling rates.",
        |settings| {
            settings.pruning.method = PruningMethod::FirstCamera;
        },
    ),
    (
        "Keep everything",
        "No pruning, neither over time nor between cameras: the reference for all others.",
        |settings| {
            settings.pruning.method = PruningMethod::Off;
            settings.spans.levels = SpanLevels::Off;
        },
    ),
];

/// The defaults with a change.
pub(crate) fn changed(change: fn(&mut Settings)) -> Settings {
    let mut settings = Settings::default();
    change(&mut settings);
    settings
}

/// Settings that the person keeps, with their name.
pub(crate) type OwnPreset = (String, Settings);

/// Keeps settings under a name, in place of those that had it.
pub(crate) fn keep(own: &mut Vec<OwnPreset>, name: &str, settings: &Settings) {
    if name.is_empty() {
        return;
    }
    match own.iter_mut().find(|(known, _)| known == name) {
        Some((_, kept)) => kept.clone_from(settings),
        None => own.push((name.to_owned(), settings.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid_and_different() {
        let all: Vec<Settings> = PRESETS
            .iter()
            .map(|(name, _, change)| {
                let mut settings = Settings::default();
                change(&mut settings);
                settings.validate(name).unwrap();
                settings
            })
            .collect();
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| a != b), "{}", PRESETS[i].0);
        }
    }

    #[test]
    fn settings_kept_under_a_name_that_is_taken_replace_those() {
        let mut own = Vec::new();
        let mut bold = Settings::default();
        PRESETS[3].2(&mut bold);
        keep(&mut own, "mine", &Settings::default());
        keep(&mut own, "other", &Settings::default());
        keep(&mut own, "mine", &bold);
        keep(&mut own, "", &bold);
        assert_eq!(own, [("mine".to_owned(), bold), ("other".to_owned(), Settings::default())]);
    }
}
