//! Edit lists as text: TOML, a table an edit.
//!
//! ```toml
//! version = 1
//!
//! [[edit]]
//! name = "the box of the desk"
//! do = "keep_only"
//! region = { box = { center = [0.0, 0.0, 1.0], half_size = [1.0, 1.0, 0.5] } }
//! ```

use std::fmt::Write;
use std::path::Path;

use serde::Deserialize;

use super::list::{Action, Edit, EditList, Reach, edit_place};
use super::region::Region;
use crate::error::{Error, Result};
use crate::settings::toml_error;
use crate::whole_file;

/// The version that is written, and the highest that is read.
const VERSION: u32 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileForm {
    /// Read before, so that it is known here.
    #[serde(rename = "version")]
    _version: u32,
    #[serde(default)]
    edit: Vec<EditForm>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EditForm {
    #[serde(default)]
    name: String,
    #[serde(default = "yes")]
    on: bool,
    #[serde(rename = "do")]
    action: Action,
    region: Region,
    frames: Option<[i64; 2]>,
    #[serde(default)]
    reach: Reach,
}

fn yes() -> bool {
    true
}

/// Reads the version alone, so that a newer file is refused by it, not by a new key.
#[derive(Deserialize)]
struct VersionForm {
    version: u32,
}

impl EditList {
    /// Reads a list from TOML text; `place` is named in errors.
    ///
    /// # Errors
    /// `Invalid` for broken TOML, unknown keys, numbers that make no region; `Unsupported` for a newer version.
    pub fn from_toml(text: &str, place: &str) -> Result<Self> {
        let version: VersionForm = toml::from_str(text).map_err(|error| toml_error(&error, place, text))?;
        if version.version != VERSION {
            let what = format!(
                "it has version {}, this Overlook reads version {VERSION}; use the Overlook that wrote it",
                version.version
            );
            return Err(Error::unsupported(place, what));
        }
        let form: FileForm = toml::from_str(text).map_err(|error| toml_error(&error, place, text))?;
        let edits = form.edit.into_iter().map(|form| {
            let EditForm { name, on: is_on, action, region, frames, reach } = form;
            Edit { name, is_on, action, region, frames, reach }
        });
        let list = Self { edits: edits.collect() };
        for (index, edit) in list.edits.iter().enumerate() {
            if let Some(fault) = edit.fault() {
                return Err(Error::invalid(edit_place(place, index, edit), fault));
            }
        }
        Ok(list)
    }

    /// Reads a list from a file.
    ///
    /// # Errors
    /// `Io` where it cannot be read, and as [`EditList::from_toml`].
    pub fn load(path: &Path) -> Result<Self> {
        Self::from_toml(&whole_file::short_text(path)?, &path.display().to_string())
    }

    /// This list as TOML, which reads back as it is.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("version = {VERSION}\n");
        for edit in &self.edits {
            let name = toml::Value::from(edit.name.as_str());
            let action = Action::NAMES.iter().find(|(action, _)| *action == edit.action);
            let action = action.map_or("", |(_, name)| name);
            let _ = write!(text, "\n[[edit]]\nname = {name}\n");
            if !edit.is_on {
                text += "on = false\n";
            }
            let _ = writeln!(text, "do = \"{action}\"");
            let region =
                toml::Value::try_from(&edit.region).map_or_else(|_| String::new(), |it| it.to_string());
            let _ = writeln!(text, "region = {region}");
            if let Some([first, last]) = edit.frames {
                let _ = writeln!(text, "frames = [{first}, {last}]");
            }
            if edit.reach == Reach::Span {
                text += "reach = \"span\"\n";
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::super::region::{Stroke, Viewpoint};
    use super::*;

    fn example() -> EditList {
        let sphere = Region::Sphere { center: [0.1, -2.0, 3.0], radius: 0.5 };
        let outline = vec![[1.0, 2.0], [30.5, 2.0], [30.5, 40.0]];
        let stroke = Stroke { radius: 2.5, points: vec![[1.0, 2.0], [3.5, 4.0]] };
        let seen = Region::Pixels {
            camera: "b".to_owned(),
            frame: Some(-3),
            outline: Vec::new(),
            strokes: vec![stroke.clone()],
        };
        let pixels = Region::Pixels {
            camera: "left \"one\"".to_owned(),
            frame: None,
            outline: outline.clone(),
            strokes: Vec::new(),
        };
        let viewpoint = Viewpoint {
            size: [40, 30],
            focal_length: [30.0, 31.0],
            principal_point: [20.0, 15.0],
            world_from_camera: glam::DAffine3::IDENTITY.to_cols_array_2d(),
            orthographic: true,
        };
        let view = Region::View { viewpoint, frame: Some(2), outline, strokes: vec![stroke], depth: None };
        let surface = Region::same_surface([0.5, 0.25, -1.0], 7);
        let grown = Region::Grow { region: Box::new(Region::Any(vec![seen, view])), footprints: 2.0 };
        let shrunk = Region::Shrink { region: Box::new(surface), footprints: 1.5 };
        let mut timed = Edit::new("a thing\nthat passes", Action::Delete, pixels.clone());
        (timed.frames, timed.reach, timed.is_on) = (Some([-3, 7]), Reach::Span, false);
        let hot = Region::Value { name: "T \"hot\"".to_owned(), from: -0.5, to: f64::INFINITY };
        let green = Region::Color { linear: [0.02, 0.4, 0.1], tolerance: 24.0 };
        let rest = Region::Without(vec![
            Region::Any(vec![sphere.clone(), hot, green, Region::Doubtful, Region::ConfirmedByFewerThan(2)]),
            Region::Not(Box::new(Region::All(vec![pixels, Region::Contradicted]))),
        ]);
        let cameras = Region::Cameras(vec!["b".to_owned()]);
        let edits = vec![
            Edit::new("", Action::LeaveOut, cameras),
            timed,
            Edit::new("rest", Action::KeepOnly, rest),
            Edit::new("back", Action::Restore, sphere),
            Edit::new("grown", Action::Delete, Region::Without(vec![grown, shrunk])),
        ];
        EditList { edits }
    }

    #[test]
    fn a_list_reads_back_as_it_was_written() {
        let list = example();
        let text = list.to_toml();
        assert_eq!(EditList::from_toml(&text, "edits.toml").unwrap(), list, "{text}");
        assert_eq!(EditList::from_toml("version = 1\n", "edits.toml").unwrap(), EditList::default());
    }

    #[test]
    fn what_is_wrong_with_a_list_is_said_in_one_line_with_its_place() {
        let said = |text: &str| EditList::from_toml(text, "e.toml").unwrap_err().to_string();
        let edit = |rest: &str| format!("version = 1\n[[edit]]\nname = \"x\"\n{rest}\n");
        for (text, expected) in [
            ("version = 2\nfuture = 1\n".to_owned(), "version 2"),
            ("edit = []".to_owned(), "version"),
            (edit("do = \"erase\"\nregion = \"doubtful\""), "line 4"),
            (
                edit("do = \"delete\"\nregion = { sphere = { center = [0, 0, 0], radius = 0 } }"),
                "edit 1 (x): a sphere",
            ),
            (edit("do = \"delete\"\nregion = { ball = 1 }"), "line 5"),
            (edit("do = \"leave_out\"\nregion = \"doubtful\""), "leave_out needs"),
            (edit("do = \"delete\"\nregion = \"doubtful\"\nframes = [5, 2]"), "frames = [5, 2]"),
            (
                edit("do = \"delete\"\nregion = { pixels = { camera = \"a\", outline = [[0, 0]] } }"),
                "three corners",
            ),
            (
                edit(
                    "do = \"delete\"\nregion = { pixels = { camera = \"a\", strokes = [{ radius = 0, points = [[0, 0]] }] } }",
                ),
                "a stroke needs",
            ),
            (edit("do = \"delete\"\nregion = { pixels = { camera = \"a\" } }"), "give strokes"),
            (
                edit("do = \"delete\"\nregion = { grow = { region = \"doubtful\", footprints = 0 } }"),
                "footprints = 0",
            ),
            (
                edit(
                    "do = \"delete\"\nregion = { same_surface = { seed = [0, 0, 0], frame = 0, angle = 100 } }",
                ),
                "same_surface needs",
            ),
            (
                edit("do = \"delete\"\nregion = { color = { linear = [0, 1, 0], tolerance = -1 } }"),
                "a color needs",
            ),
            (
                edit("do = \"delete\"\nregion = { value = { name = \"T\", from = 3, to = nan } }"),
                "value 'T' goes",
            ),
            (edit("do = \"delete\"\nregion = { any = [{ depth = { from = 3, to = 2 } }] }"), "depth goes"),
        ] {
            let error = said(&text);
            assert!(error.starts_with("e.toml") && error.contains(expected), "{error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
