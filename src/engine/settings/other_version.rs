//! Settings that another version of the program wrote.

use super::Settings;

impl Settings {
    /// Reads what is known here of settings as TOML text that another version may have written: the settings, and each of the text that
    /// this version does not have or whose value it does not take, as `section.name = value`. Those keep their defaults. `None` for broken
    /// TOML.
    #[must_use]
    pub fn known_from_toml(text: &str) -> Option<(Self, Vec<String>)> {
        let table: toml::Table = text.parse().ok()?;
        let (mut settings, mut unknown) = (Self::default(), Vec::new());
        for (section, values) in table {
            for (name, value) in values.as_table().cloned().unwrap_or_default() {
                let stated = format!("{section}.{name} = {value}");
                if settings.set(&format!("{section}.{name}"), value).is_err() {
                    unknown.push(stated);
                }
            }
        }
        Some((settings, unknown))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Antialias;

    #[test]
    fn a_value_that_is_not_known_costs_no_other_setting() {
        let text = "[pruning]\ndepth_tolerance = 2.0\n[render]\nfill = \"texture\"\nviews = 3\n";
        let (settings, unknown) = Settings::known_from_toml(text).unwrap();
        let mut expected = Settings::default();
        expected.pruning.depth_tolerance = 2.0;
        expected.render.views = 3;
        assert_eq!(settings, expected);
        assert_eq!(unknown, ["render.fill = \"texture\""]);
        assert_eq!(Settings::known_from_toml("[render"), None);
    }

    #[test]
    fn a_setting_that_was_a_switch_is_read_as_the_choice_that_it_became() {
        for (switch, expected) in [("true", Antialias::Silhouettes), ("false", Antialias::Off)] {
            let text = format!("[render]\nantialias = {switch}\n");
            let (settings, unknown) = Settings::known_from_toml(&text).unwrap();
            assert_eq!((settings.render.antialias, unknown), (expected, Vec::new()));
            assert_eq!(Settings::from_toml(&text, "test").unwrap(), settings);
            let mut set = Settings::default();
            set.set_text(&format!("render.antialias={switch}")).unwrap();
            assert_eq!(set, settings);
        }
        let error = Settings::default().set_text("render.free_space=sometimes").unwrap_err().to_string();
        assert!(error.contains("boolean"), "{error}");
    }

    #[test]
    fn all_settings_are_known_from_their_own_text() {
        let mut settings = Settings::default();
        settings.set_text("pruning.rate=footprint").unwrap();
        settings.set_text("render.views=3").unwrap();
        assert_eq!(Settings::known_from_toml(&settings.to_toml()), Some((settings, Vec::new())));
    }
}
