//! Names of files: what is proposed, what is typed, and the endings that they need.

use std::path::PathBuf;

use crate::app::model::State;
use crate::app::rooms::files::model::{Purpose, SESSION_ENDING, TypedPath};
use crate::app::rooms::files::work::with_ending;
use crate::app::rooms::share::work::FIGURE_ENDINGS;
use overlook_engine::splats::SplatFormat;

/// What is wrong with a name that [`named`] does not take.
pub(crate) fn other_ending(purpose: Purpose) -> String {
    match endings(purpose) {
        Some([ending, ..]) => format!("A file of this kind is named .{ending}."),
        _ => "A picture is written as PNG or EXR; name it .png or .exr.".to_owned(),
    }
}

/// The endings that a file of a purpose may have and no others, the usual one first; `None` where others may be typed on purpose.
fn endings(purpose: Purpose) -> Option<&'static [&'static str]> {
    match purpose {
        Purpose::ExportFilm => Some(&["mp4", "m4v"]),
        Purpose::ExportPage => Some(&["html", "htm"]),
        Purpose::ExportFigure | Purpose::SaveChart(_) => Some(&FIGURE_ENDINGS),
        Purpose::SaveTable(_) => Some(&["csv", "md", "tex"]),
        Purpose::SaveSession => Some(&[SESSION_ENDING]),
        Purpose::SaveCameras => Some(&["json"]),
        Purpose::ExportSplats(SplatFormat::Ply) | Purpose::ExportPoints => Some(&["ply"]),
        Purpose::ExportSplats(SplatFormat::Spz) => Some(&["spz"]),
        Purpose::ExportSplats(SplatFormat::Glb) => Some(&["glb"]),
        Purpose::ExportSplats(SplatFormat::Usda) => Some(&["usda"]),
        _ => None,
    }
}

/// A likely name of a file to write; empty for a path that must exist already.
pub(crate) fn suggested_name(state: &State, purpose: Purpose) -> String {
    let name = state.doc.scene.as_ref().map_or("capture", |scene| &scene.name);
    match purpose {
        Purpose::SaveStore => format!("{name}.ovl"),
        Purpose::ExportPage => format!("{name}.html"),
        Purpose::ExportSplats(format) => format!("{name}.{format}"),
        Purpose::ExportFigure => "figure.pdf".to_owned(),
        Purpose::ExportPoints => "points.ply".to_owned(),
        Purpose::ExportPointsOfFrames => "points".to_owned(),
        Purpose::SavePicture if state.share.options.linear => "picture.exr".to_owned(),
        Purpose::SaveSettings => "settings.toml".to_owned(),
        Purpose::SavePicture => "picture.png".to_owned(),
        Purpose::SaveTable(table) => table.file().to_owned(),
        Purpose::SaveChart(study) => study.chart_file().to_owned(),
        Purpose::ExportPictures | Purpose::ExportExr => "pictures".to_owned(),
        Purpose::ExportFilm => "video.mp4".to_owned(),
        Purpose::SaveCameras => "cameras.json".to_owned(),
        Purpose::SavePath => "transforms.json".to_owned(),
        Purpose::SaveEdits => "edits.toml".to_owned(),
        Purpose::SaveSession => format!("session.{SESSION_ENDING}"),
        Purpose::OpenFile
        | Purpose::OpenFolder
        | Purpose::LoadSettings
        | Purpose::LoadPath
        | Purpose::LoadEdits
        | Purpose::OpenPictures => String::new(),
    }
}

/// The path of a typed text, with `~` for the home folder; `None` for an empty text.
pub(crate) fn place(text: &str) -> Option<PathBuf> {
    let text = text.trim();
    let at_home = text.strip_prefix('~').filter(|rest| rest.is_empty() || rest.starts_with('/'));
    let path = match (at_home, std::env::home_dir()) {
        (Some(rest), Some(home)) => home.join(rest.trim_start_matches('/')),
        _ => PathBuf::from(text),
    };
    (!text.is_empty()).then(|| lasting(path))
}

/// The path with the ending that a file of this purpose needs; `None` if it has the ending of another kind of file.
pub(crate) fn named(purpose: Purpose, path: PathBuf) -> Option<PathBuf> {
    let ending = match purpose {
        Purpose::SavePicture => return with_ending(path),
        Purpose::SaveStore => "ovl",
        Purpose::SaveSettings | Purpose::SaveEdits => "toml",
        Purpose::SaveTable(_) => "csv",
        _ => match endings(purpose) {
            Some([usual, ..]) => usual,
            _ => return Some(path),
        },
    };
    // Digits after a dot, as in `take.2`, are part of the name; any other ending was typed on purpose.
    let known = path
        .extension()
        .is_some_and(|typed| typed.len() > 1 && !typed.to_string_lossy().chars().all(|c| c.is_ascii_digit()));
    if let (true, Some(endings)) = (known, endings(purpose)) {
        let is_one = |ending: &&str| path.extension().is_some_and(|typed| typed.eq_ignore_ascii_case(ending));
        return endings.iter().any(is_one).then_some(path);
    }
    Some(if known { path } else { PathBuf::from(format!("{}.{ending}", path.display())) })
}

/// The destination of the path in the field; `None` if it cannot be taken.
pub(crate) fn typed_destination(typed: &TypedPath) -> Option<PathBuf> {
    named(typed.purpose, place(&typed.text)?)
}

/// A path that stays valid when the window is started from another folder.
pub(crate) fn lasting(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::rooms::charts::model::Study;

    #[test]
    fn a_name_without_an_ending_gets_that_of_its_purpose() {
        let named = |purpose, path: &str| named(purpose, path.into()).unwrap();
        assert_eq!(named(Purpose::SaveStore, "/a/capture"), PathBuf::from("/a/capture.ovl"));
        assert_eq!(named(Purpose::SaveStore, "/a/take.2"), PathBuf::from("/a/take.2.ovl"));
        assert_eq!(named(Purpose::SaveStore, "/a/capture.ovl"), PathBuf::from("/a/capture.ovl"));
        assert_eq!(named(Purpose::SaveSettings, "/a/mine"), PathBuf::from("/a/mine.toml"));
        assert_eq!(named(Purpose::ExportFilm, "/a/b.m4v"), PathBuf::from("/a/b.m4v"));
        assert_eq!(named(Purpose::OpenFile, "/a/folder"), PathBuf::from("/a/folder"));
        assert_eq!(named(Purpose::ExportPage, "/a/scene"), PathBuf::from("/a/scene.html"));
        assert_eq!(named(Purpose::ExportPage, "/a/scene.HTM"), PathBuf::from("/a/scene.HTM"));
        let chart = Purpose::SaveChart(Study::Sweep);
        assert_eq!(named(chart, "/a/sweep"), PathBuf::from("/a/sweep.pdf"));
        assert_eq!(named(chart, "/a/sweep.SVG"), PathBuf::from("/a/sweep.SVG"));
        let splats = Purpose::ExportSplats(SplatFormat::Glb);
        assert_eq!(named(splats, "/a/scene.2"), PathBuf::from("/a/scene.2.glb"));
        for (purpose, path) in [
            (Purpose::ExportPage, "/a/scene.ovl"),
            (splats, "/a/b.ply"),
            (Purpose::ExportPoints, "/a/b.ovl"),
            (chart, "/a/b.jpg"),
        ] {
            assert_eq!(
                super::named(purpose, path.into()),
                None,
                "a store is not replaced by what is shared of it"
            );
        }
    }

    #[test]
    fn a_tilde_that_is_typed_is_the_own_folder() {
        let home = std::env::home_dir().unwrap();
        assert_eq!(place(" ~/films/a.mp4 "), Some(home.join("films/a.mp4")));
        assert_eq!(place("~"), Some(home.join("")));
        assert_eq!(place("/data/~x/~"), Some(PathBuf::from("/data/~x/~")));
        assert_eq!(place("~x"), Some(lasting("~x".into())));
        assert_eq!(place("  "), None);
    }
}
