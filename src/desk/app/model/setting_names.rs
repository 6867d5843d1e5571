//! What settings are called in the window.

use crate::text;
use overlook_engine::settings::{Field, Settings};

/// Sections in the order of the panel: id, heading, whether it is open at first.
pub(crate) const SECTIONS: &[(&str, &str, bool)] = &[
    ("pruning", "Redundancy between cameras", true),
    ("spans", "Temporal redundancy", true),
    ("render", "Rendering", true),
    ("align", "Alignment", false),
    ("normals", "Surface normals", false),
    ("store", "Store encoding", false),
    ("capture", "Loading", false),
];

/// Settings that are folded away: few scenes ask for another value than the default.
pub(crate) const ADVANCED: &[&str] = &[
    "pruning.cosine_floor",
    "pruning.across_spans",
    "pruning.overlap",
    "pruning.agreement_margin",
    "render.free_space",
    "render.depth_tolerance",
    "render.views",
    "render.coarse",
    "render.magnified",
];

/// What every setting is called, by its path: no two alike.
const NAMES: &[(&str, &str)] = &[
    ("capture.memory", "Memory"),
    ("capture.views", "Views read"),
    ("align.poses", "Correct poses"),
    ("align.lens", "Correct color lens"),
    ("align.exposure", "Correct exposure"),
    ("align.clock", "Correct clocks"),
    ("normals.source", "Normals from"),
    ("normals.estimator", "Normal estimation"),
    ("normals.edge", "Depth edge"),
    ("spans.levels", "Time spans"),
    ("spans.color_tolerance", "Static color range"),
    ("spans.depth_tolerance", "Static depth range"),
    ("spans.noise", "Noise multiplier"),
    ("pruning.method", "Pruning method"),
    ("pruning.rate", "Sampling rate"),
    ("pruning.depth_tolerance", "Depth tolerance"),
    ("pruning.normal_tolerance", "Normal tolerance"),
    ("pruning.color_tolerance", "Color tolerance"),
    ("pruning.cosine_floor", "Minimum cos θ"),
    ("pruning.across_spans", "Match static with moving"),
    ("pruning.overlap", "Keep 1-px overlap"),
    ("pruning.mixed_pixels", "Edge-blended pixels"),
    ("pruning.agreement", "Cross-camera check"),
    ("pruning.agreement_margin", "Vote margin"),
    ("store.normals", "Store normals"),
    ("store.precision", "Precision"),
    ("store.depth_precision", "Depth error limit"),
    ("store.coding", "Compression"),
    ("store.verdicts", "Room for verdicts"),
    ("render.kernel", "Kernel"),
    ("render.fill", "Hole filling"),
    ("render.free_space", "Line-of-sight test"),
    ("render.depth_tolerance", "Blending depth range"),
    ("render.views", "Averaged cameras"),
    ("render.antialias", "Antialiasing"),
    ("render.coarse", "Coarse pictures"),
    ("render.magnified", "Close-ups"),
    ("render.backend", "Renderer"),
];

/// What choices are called whose names in files would not do.
const CHOICES: &[(&str, &str, &str)] = &[
    ("spans.levels", "paper", "As in the paper"),
    ("spans.levels", "tree", "Hierarchical"),
    ("pruning.method", "highest_rate", "Highest sampling rate"),
    ("pruning.rate", "paper", "Paper r"),
    ("pruning.rate", "footprint", "Footprint area"),
    ("pruning.rate", "stretch", "Longest footprint side"),
    ("pruning.mixed_pixels", "yield", "Prefer clean ones"),
    ("pruning.agreement", "majority", "Majority vote"),
    ("store.precision", "bits16", "16 bits"),
    ("store.precision", "bits12", "12 bits"),
    ("store.precision", "bits10", "10 bits"),
    ("store.precision", "bits8", "8 bits"),
    ("store.coding", "modeled", "Predictive"),
    ("store.coding", "plain", "None"),
    ("render.kernel", "block", "Block (2×2)"),
    ("render.kernel", "gather", "Gather (interpolate cameras)"),
    ("render.fill", "pushpull", "Push-pull"),
    ("render.backend", "cpu", "CPU"),
    ("render.backend", "gpu", "GPU"),
];

/// A setting by its name in the panel.
pub(crate) fn name(path: &str) -> String {
    let named = NAMES.iter().find(|(of, _)| *of == path);
    named.map_or_else(|| text::words(path), |(_, name)| (*name).to_owned())
}

/// A choice of a setting by its name in the panel.
pub(crate) fn choice(path: &str, choice: &str) -> String {
    let named = CHOICES.iter().find(|(of, value, _)| *of == path && *value == choice);
    named.map_or_else(|| text::words(choice), |(.., name)| (*name).to_owned())
}

/// A value as the panel shows it.
fn value(path: &str, value: &toml::Value) -> String {
    match value {
        toml::Value::Boolean(on) => if *on { "on" } else { "off" }.to_owned(),
        toml::Value::String(chosen) => choice(path, chosen),
        // Settings have no more digits than this.
        toml::Value::Float(number) => (*number as f32).to_string(),
        other => other.to_string(),
    }
}

/// Two settings as tables: converted once, not once a field.
pub(crate) struct SettingPairs([toml::Table; 2]);

impl SettingPairs {
    /// The values of `one` beside those of `other`.
    pub(crate) fn new(one: &Settings, other: &Settings) -> Self {
        Self([one, other].map(|settings| toml::Table::try_from(settings).unwrap_or_default()))
    }

    /// Both values of a setting.
    pub(crate) fn of(&self, field: &Field) -> Option<[&toml::Value; 2]> {
        let (section, name) = field.path.split_once('.')?;
        let [one, other] = &self.0;
        Some([one.get(section)?.get(name)?, other.get(section)?.get(name)?])
    }

    /// The settings whose values differ, with both.
    pub(crate) fn differing(&self) -> impl Iterator<Item = (&'static Field, [&toml::Value; 2])> {
        let pairs = Settings::fields().filter_map(|field| Some((field, self.of(field)?)));
        pairs.filter(|(_, [one, other])| one != other)
    }
}

/// What `after` has other than `before`, by the panel's names: `Kernel: Gather (interpolate cameras) » Point`.
pub(crate) fn changes(before: &Settings, after: &Settings) -> Vec<String> {
    let words = |(field, [before, after]): (&Field, [&toml::Value; 2])| {
        format!("{}: {} » {}", name(field.path), value(field.path, before), value(field.path, after))
    };
    SettingPairs::new(before, after).differing().map(words).collect()
}

/// The label of a point of a sweep with its settings as the panel calls them.
pub(crate) fn label(label: &str) -> String {
    let part = |part: &str| match part.split_once(" = ") {
        Some((path, set)) if Settings::fields().any(|field| field.path == path) => {
            let set = match set {
                "true" => "on".to_owned(),
                "false" => "off".to_owned(),
                number if number.parse::<f64>().is_ok() => number.to_owned(),
                chosen => choice(path, chosen),
            };
            format!("{}: {set}", name(path))
        }
        _ => part.to_owned(),
    };
    label.split(", ").map(part).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_and_choice_has_a_name_of_its_own() {
        let mut known = std::collections::HashSet::new();
        for field in Settings::fields() {
            assert!(NAMES.iter().any(|(path, _)| *path == field.path), "{} has no name", field.path);
            assert!(known.insert(name(field.path)), "{} is called as another", field.path);
            if let overlook_engine::settings::ValueKind::Choice(choices) = field.kind {
                let names: std::collections::HashSet<_> =
                    choices.iter().map(|(value, _)| choice(field.path, value)).collect();
                assert_eq!(names.len(), choices.len(), "{}", field.path);
            }
        }
        for (path, value, _) in CHOICES {
            assert!(Settings::default().set_text(&format!("{path}={value}")).is_ok(), "{path} = {value}");
        }
    }

    #[test]
    fn settings_are_called_as_in_the_panel() {
        assert_eq!(label("spans.color_tolerance = 4, gather"), "Static color range: 4, gather");
        assert_eq!(label("pruning.overlap = false, point"), "Keep 1-px overlap: off, point");
        let without_any = "first camera wins, as many samples, gather";
        assert_eq!(label(without_any), without_any);
    }

    #[test]
    fn every_changed_setting_is_told_with_what_it_was() {
        let before = Settings::default();
        let mut after = before.clone();
        after.set_text("spans.depth_tolerance=0.004").unwrap();
        after.set_text("render.kernel=point").unwrap();
        assert_eq!(changes(&before, &before), Vec::<String>::new());
        let told = changes(&before, &after);
        assert!(told[0].starts_with("Static depth range: ") && told[0].ends_with(" » 0.004"), "{told:?}");
        assert_eq!(told[1..], ["Kernel: Gather (interpolate cameras) » Point"]);
    }
}
