//! A session as a text: what is open, and all that was set about it, so that a window opens with it again, here or elsewhere.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use egui::{ColorImage, TextureHandle, TextureOptions};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::app::model::look::Display;
use crate::app::model::picture::{ColorBy, HoleDisplay, Overlay};
use crate::app::model::setting_names::SettingPairs;
use crate::app::model::texture::RECENT_SIDES;
use crate::app::rooms::compare::state::{CompareMeasure, CompareMode, CompareSide, CompareVantage};
use crate::app::rooms::live::state::KeptView;
use overlook_engine::capture::transforms::{Easing, PathView, path_from_json, path_to_json};
use overlook_engine::edits::EditList;
use overlook_engine::error::{Error, Result};
use overlook_engine::settings::Settings;

/// The ending of a session's file.
pub(crate) const SESSION_ENDING: &str = "overlook";

/// The version of the form.
const VERSION: u32 = 1;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Session {
    /// What is open: a capture or a store. Absolute.
    pub opens: PathBuf,
    pub settings: Settings,
    pub edits: EditList,
    /// The views of the camera path, with keys marked; empty without one.
    pub path: Vec<PathView>,
    /// How its camera sets off and arrives, and the point in world space that it looks at.
    pub path_easing: Easing,
    pub path_looks_at: Option<DVec3>,
    /// Up in the world: as chosen, or as the capture has it.
    pub up_in_world: DVec3,
    /// The address of the view, as `#view=…&frame=…`.
    pub view: String,
    /// The arrangement of the views, as the window remembers it.
    pub layout: String,
    /// How both views look; `None` in sessions that do not say it.
    pub look: Option<SessionLook>,
    pub kept_views: Vec<KeptView>,
}

/// The file.
#[serde_with::skip_serializing_none]
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SessionForm {
    version: u32,
    /// Relative to the file where it lies below its folder.
    opens: PathBuf,
    /// The same relative to the file, where it does not: both may be moved together.
    opens_beside: Option<PathBuf>,
    up: [f64; 3],
    #[serde(default)]
    view: String,
    #[serde(default)]
    settings: String,
    #[serde(default)]
    edits: String,
    #[serde(default)]
    path: String,
    /// Pictures from each key of the path to the next; empty where the path has them itself.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    path_pictures: Vec<usize>,
    path_easing: Option<Easing>,
    path_looks_at: Option<[f64; 3]>,
    #[serde(default)]
    layout: String,
    look: Option<SessionLook>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    kept_view: Vec<KeptView>,
}

impl Session {
    /// Whether a path is that of a session, by its ending.
    pub(crate) fn is_session(path: &Path) -> bool {
        path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(SESSION_ENDING))
    }

    /// The text of a file at `place`. Its first lines say how to prune the same without a window.
    ///
    /// # Errors
    /// `Invalid` where the camera path cannot be written.
    pub(crate) fn to_text(&self, place: &Path) -> Result<String> {
        let folder = place.parent().unwrap_or(Path::new(""));
        let keys: Vec<PathView> = self.path.iter().filter(|view| view.is_key).cloned().collect();
        let path = if self.path.is_empty() {
            String::new()
        } else {
            // The session says how the path is eased, also of one without pictures.
            path_to_json(self.up_in_world, &keys, Easing::Linear)?
        };
        let form = SessionForm {
            version: VERSION,
            opens: self.opens.strip_prefix(folder).unwrap_or(&self.opens).to_path_buf(),
            opens_beside: beside(&self.opens, folder),
            up: self.up_in_world.to_array(),
            view: self.view.clone(),
            settings: self.settings.to_toml(),
            edits: if self.has_edits() { self.edits.to_toml() } else { String::new() },
            path,
            path_pictures: legs(&self.path),
            path_easing: Some(self.path_easing).filter(|easing| *easing != Easing::Linear),
            path_looks_at: self.path_looks_at.map(|point| point.to_array()),
            layout: self.layout.clone(),
            look: self.look.clone(),
            kept_view: self.kept_views.clone(),
        };
        let text = toml::to_string_pretty(&form)
            .map_err(|error| Error::invalid(place.display(), error.to_string()))?;
        let edits = if self.has_edits() { ", which Save > Save edits writes" } else { "" };
        let line = self.command_line();
        Ok(format!("# A session of Overlook: overlook open {}\n# {line}{edits}\n{text}", quoted(place)))
    }

    /// Reads a file's text.
    ///
    /// # Errors
    /// `Invalid` with what is wrong where.
    pub(crate) fn from_text(text: &str, place: &Path) -> Result<Self> {
        let name = place.display().to_string();
        let invalid = |what: &str| Error::invalid(&name, what);
        let form: SessionForm = toml::from_str(text).map_err(|error| {
            let before = error.span().map_or("", |span| &text[..span.start.min(text.len())]);
            let line = before.matches('\n').count() + 1;
            invalid(&format!("line {line}: {}", error.message()))
        })?;
        if form.version != VERSION {
            let what = format!(
                "it has version {}, this Overlook reads version {VERSION}; use the Overlook that wrote it",
                form.version
            );
            return Err(invalid(&what));
        }
        let folder = place.parent().unwrap_or(Path::new(""));
        let edits = if form.edits.is_empty() {
            EditList::default()
        } else {
            EditList::from_toml(&form.edits, &name)?
        };
        let path =
            if form.path.is_empty() { Vec::new() } else { path_from_json(form.path.as_bytes(), place)? };
        let up = DVec3::from(form.up).try_normalize();
        let no_up = "\"up\" is no direction; write it as three numbers, as in [0, 0, 1]";
        let up = up.ok_or_else(|| invalid(no_up))?;
        if form.look.as_ref().is_some_and(|look| !look.is_finite()) {
            return Err(invalid("[look]: a number cannot be shown; write finite ones, and a gamma above 0"));
        }
        let opens = folder.join(form.opens);
        let moved = form.opens_beside.map(|beside| folder.join(beside)).filter(|_| !opens.exists());
        Ok(Self {
            opens: moved.filter(|moved| moved.exists()).unwrap_or(opens),
            settings: Settings::from_toml(&form.settings, &name)?,
            edits,
            path: with_pictures(path, &form.path_pictures),
            path_easing: form.path_easing.unwrap_or(Easing::Linear),
            path_looks_at: form.path_looks_at.map(DVec3::from).filter(|point| point.is_finite()),
            up_in_world: up,
            view: form.view,
            layout: form.layout,
            look: form.look,
            kept_views: form.kept_view,
        })
    }

    /// Whether pruning the same takes a list of edits.
    pub(crate) fn has_edits(&self) -> bool {
        !self.edits.edits.is_empty()
    }

    /// The command that prunes the same. Edits are in a file beside it.
    pub(crate) fn command_line(&self) -> String {
        let defaults = Settings::default();
        let pairs = SettingPairs::new(&self.settings, &defaults);
        let mut line = format!("overlook preprocess {} --out scene.ovl", quoted(&self.opens));
        for (field, [value, _]) in pairs.differing() {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            // A string takes all that is written.
            let _ = write!(line, " --set {}={value}", field.path);
        }
        if self.has_edits() {
            line += " --edits edits.toml";
        }
        line
    }
}

/// The views from each key of a path to the next one, or to the end.
fn legs(views: &[PathView]) -> Vec<usize> {
    let keys: Vec<usize> = (0..views.len()).filter(|at| views[*at].is_key).collect();
    let ends = keys.iter().skip(1).copied().chain([views.len()]);
    keys.iter().zip(ends).map(|(key, end)| end - key).collect()
}

/// More pictures from one key to the next are a damaged file.
const MOST_PICTURES: usize = 2000;

/// The views of a path of keys with so many pictures from each to the next: the pace is what matters of those between.
fn with_pictures(keys: Vec<PathView>, legs: &[usize]) -> Vec<PathView> {
    if keys.len() != legs.len() {
        return keys;
    }
    let leg = |(key, count): (PathView, &usize)| {
        let between = PathView { is_key: false, ..key.clone() };
        let others = std::iter::repeat_n(between, (*count).clamp(1, MOST_PICTURES) - 1);
        std::iter::once(key).chain(others)
    };
    keys.into_iter().zip(legs).flat_map(leg).collect()
}

/// A path from a folder to where both lie, and from there; `None` where it lies below the folder or has nothing in common with it.
fn beside(path: &Path, folder: &Path) -> Option<PathBuf> {
    let common = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().count() - common;
    let rest: PathBuf = path.components().skip(common).collect();
    (common > 1 && up > 0).then(|| std::iter::repeat_n("..", up).collect::<PathBuf>().join(rest))
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "/._-+,=:@".contains(letter);
    if text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// What the live view showed last of a file or folder, small.
pub(crate) struct RecentPicture {
    pub path: PathBuf,
    pub image: Arc<ColorImage>,
    pub texture: TextureHandle,
}

impl RecentPicture {
    pub(crate) fn new(ctx: &egui::Context, path: PathBuf, image: ColorImage) -> Self {
        let image = Arc::new(image);
        let texture = ctx.load_texture("recent picture", image.clone(), TextureOptions::LINEAR);
        Self { path, image, texture }
    }

    /// As text: a PNG in base64; `None` where it has no pixels.
    pub(crate) fn to_text(&self) -> Option<String> {
        let [width, height] = self.image.size;
        let bytes: Vec<u8> =
            self.image.pixels.iter().flat_map(|color| [color.r(), color.g(), color.b()]).collect();
        let mut png = std::io::Cursor::new(Vec::new());
        let picture = image::RgbImage::from_raw(width as u32, height as u32, bytes)?;
        picture.write_to(&mut png, image::ImageFormat::Png).ok()?;
        Some(STANDARD.encode(png.into_inner()))
    }

    /// From text; `None` where it is no such picture.
    pub(crate) fn from_text(ctx: &egui::Context, path: PathBuf, text: &str) -> Option<Self> {
        let bytes = STANDARD.decode(text).ok()?;
        let picture = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).ok()?.to_rgb8();
        let size = [picture.width() as usize, picture.height() as usize];
        let is_small = size[0] <= RECENT_SIDES[0] && size[1] <= RECENT_SIDES[1];
        is_small.then(|| Self::new(ctx, path, ColorImage::from_rgb(size, picture.as_raw())))
    }
}

/// How both views look.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SessionLook {
    pub(super) overlay: Overlay,
    pub(super) color_by: ColorBy,
    pub(super) holes: HoleDisplay,
    pub(super) frames_per_second: f32,
    /// Names of cameras: the source view's, those hidden in the live view, and the only one shown there.
    pub(super) source_camera: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) hidden_cameras: Vec<String>,
    pub(super) solo_camera: Option<String>,
    /// Numbers of frames: marked ones, and the first and last that are played.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) marked_frames: Vec<i64>,
    pub(super) played_frames: Option<[i64; 2]>,
    pub(super) display: Display,
    pub(super) compare: SessionComparison,
}

/// What is compared, and how.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SessionComparison {
    pub(super) sides: [CompareSide; 2],
    pub(super) measure: CompareMeasure,
    pub(super) mode: CompareMode,
    pub(super) range: Option<f32>,
    pub(super) from: CompareVantage,
}

#[cfg(test)]
mod tests {
    use egui::Color32;

    use super::*;
    use crate::app::model::texture::smaller;

    fn session(opens: &str) -> Session {
        let mut settings = Settings::default();
        settings.pruning.depth_tolerance = 2.5;
        Session {
            opens: opens.into(),
            settings,
            edits: EditList::default(),
            path: Vec::new(),
            path_easing: Easing::InOut,
            path_looks_at: Some(DVec3::new(1.0, 2.0, 3.5)),
            up_in_world: DVec3::Z,
            view: "#view=1,2&frame=3".to_owned(),
            layout: "{}".to_owned(),
            look: None,
            kept_views: vec![KeptView {
                name: "the \"door\"".to_owned(),
                view: "#camera=a&frame=3".parse().unwrap(),
            }],
        }
    }

    #[test]
    fn a_session_is_read_as_it_was_written_and_follows_its_folder_to_another_place() {
        let text = session("/data/my scene/capture").to_text(Path::new("/data/my scene/a.overlook")).unwrap();
        let first: Vec<&str> = text.lines().take(2).collect();
        assert_eq!(first[0], "# A session of Overlook: overlook open '/data/my scene/a.overlook'");
        assert!(
            first[1].ends_with("'/data/my scene/capture' --out scene.ovl --set pruning.depth_tolerance=2.5"),
            "{}",
            first[1]
        );
        let read = Session::from_text(&text, Path::new("/else/where/a.overlook")).unwrap();
        assert_eq!(read, session("/else/where/capture"));
    }

    #[test]
    fn a_session_beside_its_capture_is_found_where_both_were_moved() {
        let folder = tempfile::tempdir().unwrap();
        let [sessions, capture] = ["sessions", "capture"].map(|name| folder.path().join("moved").join(name));
        for place in [&sessions, &capture] {
            std::fs::create_dir_all(place).unwrap();
        }
        let text = session("/data/project/capture").to_text(Path::new("/data/project/sessions/a.overlook"));
        let read = Session::from_text(&text.unwrap(), &sessions.join("a.overlook")).unwrap();
        assert_eq!(read.opens, sessions.join("../capture"));
        assert_eq!(beside(Path::new("/data/a/capture"), Path::new("/data/a")), None);
        assert_eq!(beside(Path::new("/data/capture"), Path::new("/home/me")), None);
    }

    #[test]
    fn what_is_no_session_says_where_and_why() {
        let whole = "version = 1\nopens = \"a\"\nup = [0, 0, 1]\n";
        for (text, words) in [
            ("version = 1\n".to_owned(), "missing field `opens`"),
            (whole.replace("1]", "0]"), "\"up\" is no direction"),
            (whole.replace("version = 1", "version = 2"), "this Overlook reads version 1"),
            (format!("{whole}foo = 3\n"), "line 4: unknown field `foo`"),
            (format!("{whole}settings = \"x = 1\"\n"), "unknown field `x`"),
            (format!("{whole}[look]\noverlay = \"Depth\"\n"), "missing field"),
            (format!("{whole}[look]\noverlay = \"Fog\"\n"), "unknown variant"),
            (format!("{whole}[[kept_view]]\nname = \"a\"\nview = \"x\"\n"), "is no address"),
        ] {
            let error = Session::from_text(&text, Path::new("s.overlook")).unwrap_err().to_string();
            assert!(error.starts_with("s.overlook") && error.contains(words), "{error}");
        }
    }

    #[test]
    fn a_recent_picture_is_small_and_comes_back_from_text() {
        let pixels = (0..300 * 200).map(|i| Color32::from_gray((i % 300) as u8)).collect();
        let small = smaller(&ColorImage::new([300, 200], pixels));
        let ctx = egui::Context::default();
        let recent = RecentPicture::new(&ctx, "/a".into(), small);
        assert_eq!(recent.image.size, [100, 66]);
        assert_eq!(recent.image.pixels[1], Color32::from_gray(4), "the mean of columns 3 to 5");
        let text = recent.to_text().unwrap();
        let read = |text: &str| RecentPicture::from_text(&ctx, "/a".into(), text).map(|recent| recent.image);
        assert_eq!(read(&text), Some(recent.image));
        assert_eq!(read("no picture"), None);
    }
}
