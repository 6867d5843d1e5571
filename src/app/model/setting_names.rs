//! What settings are called in the window.

use super::text;
use crate::settings::{Field, Settings};

/// Sections in the order of the panel: id, heading, whether it is open at first.
pub(crate) const SECTIONS: &[(&str, &str, bool)] = &[
    ("pruning", "Redundancy between cameras", true),
    ("spans", "Redundancy over time", true),
    ("render", "Painting the live view", true),
    ("normals", "Surface normals", false),
    ("store", "Saved file", false),
    ("capture", "Reading frames", false),
];

/// A setting by its name in the panel and, as names repeat, its heading there: `Color tolerance (Redundancy over time)`.
fn name(path: &str) -> String {
    let (section, name) = path.split_once('.').unwrap_or(("", path));
    let heading = SECTIONS.iter().find(|(of, ..)| *of == section).map_or(section, |(_, heading, _)| heading);
    format!("{} ({heading})", text::words(name))
}

/// A value as the panel shows it.
fn value(value: &toml::Value) -> String {
    match value {
        toml::Value::Boolean(on) => if *on { "on" } else { "off" }.to_owned(),
        toml::Value::String(choice) => text::words(choice),
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

/// What `after` has other than `before`, by the panel's names: `Kernel (Painting the live view): Gather → Point`.
pub(crate) fn changes(before: &Settings, after: &Settings) -> Vec<String> {
    let words = |(field, [before, after]): (&Field, [&toml::Value; 2])| {
        format!("{}: {} → {}", name(field.path), value(before), value(after))
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
                choice => text::words(choice),
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
    fn settings_are_called_as_in_the_panel() {
        assert_eq!(
            label("spans.color_tolerance = 4, gather"),
            "Color tolerance (Redundancy over time): 4, gather"
        );
        assert_eq!(
            label("pruning.overlap = false, point"),
            "Overlap (Redundancy between cameras): off, point"
        );
        assert_eq!(
            label("first camera wins, as many samples, gather"),
            "first camera wins, as many samples, gather"
        );
    }

    #[test]
    fn every_changed_setting_is_told_with_what_it_was() {
        let before = Settings::default();
        let mut after = before.clone();
        after.set_text("spans.depth_tolerance=0.004").unwrap();
        after.set_text("render.kernel=point").unwrap();
        assert_eq!(changes(&before, &before), Vec::<String>::new());
        let told = changes(&before, &after);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].starts_with("Depth tolerance (Redundancy over time): "), "{told:?}");
        assert!(told[0].ends_with(" → 0.004"), "{told:?}");
        assert_eq!(told[1], "Kernel (Painting the live view): Gather → Point");
    }
}
