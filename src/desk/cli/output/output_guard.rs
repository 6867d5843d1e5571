//! Checks of output paths before the work starts: hours of work must not end in a missing folder, and no result may overwrite its
//! input.

use std::collections::HashSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::picture::PicturePaths;
use overlook_engine::capture::Source;
use overlook_engine::capture::transforms::{MANIFEST_NAME, manifest_path, picture_places, truth_beside};
use overlook_engine::error::{Error, Result};
use overlook_engine::store::file::Store;
use overlook_engine::whole_file;

/// Refuses a file that cannot be written; `example` is a good name for the message.
pub(crate) fn check_file(out: &Path, example: &str) -> Result<()> {
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        return Err(Error::invalid(
            out.display(),
            format!("the folder {} does not exist; create it first", folder.display()),
        ));
    }
    if out.is_dir() {
        return Err(Error::invalid(
            out.display(),
            format!("is a folder; name a file in it, as in {example}"),
        ));
    }
    match whole_file::beside(out, ".probe") {
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {
            Err(Error::invalid(out.display(), "no file can be made there; name another place"))
        }
        probed => probed.map(drop),
    }
}

/// Refuses a folder that cannot be created because a file has its name or that of a parent.
pub(crate) fn check_folder(out: &Path) -> Result<()> {
    match out.ancestors().find(|place| place.is_file()) {
        None => Ok(()),
        Some(file) => {
            Err(Error::invalid(file.display(), "is a file; name a folder, or one that can be made"))
        }
    }
}

/// Refuses pictures below `out` that would overwrite pictures of the manifest or of a capture in `out`.
pub(crate) fn refuse_true_pictures(manifest: &Path, out: &Path, targets: &[PicturePaths]) -> Result<()> {
    refuse_pictures_at(manifest, &picture_places(manifest)?, targets)?;
    // The user did not name that capture: its manifest may be missing or broken.
    let other = out.join(MANIFEST_NAME);
    refuse_pictures_at(&other, &picture_places(&other).unwrap_or_default(), targets)
}

fn refuse_pictures_at(manifest: &Path, places: &[PathBuf], targets: &[PicturePaths]) -> Result<()> {
    let own: HashSet<PathBuf> = places.iter().map(|path| resolved(path)).collect();
    let written = targets.iter().flat_map(|paths| [&paths.exr, &paths.png]);
    match written.into_iter().find(|path| own.contains(&resolved(path))) {
        None => Ok(()),
        Some(taken) => Err(Error::invalid(
            taken.display(),
            format!(
                "is where {} looks for a picture of its own, which would be written over; name another folder with --out",
                manifest.display()
            ),
        )),
    }
}

/// Refuses a file that a capture or the truth beside it is read from: a list of pictures, or a picture.
pub(crate) fn refuse_capture_files(capture: &Path, views: Option<&Path>, out: &Path) -> Result<()> {
    let beside = truth_beside(capture);
    if let Some(beside) = &beside {
        refuse_input(beside, out)?;
    }
    Source::find(capture)?.places().iter().try_for_each(|file| refuse_input(file, out))?;
    views.map_or(Ok(()), |views| refuse_view_files(views, out))?;
    // The command does not read these views: they may be broken.
    let truth = beside.and_then(|beside| picture_places(&beside).ok()).unwrap_or_default();
    truth.iter().try_for_each(|picture| refuse_input(picture, out))
}

/// Refuses a file that views are read from: their manifest, or a picture that it names.
pub(crate) fn refuse_view_files(manifest: &Path, out: &Path) -> Result<()> {
    refuse_input(&manifest_path(manifest), out)?;
    picture_places(manifest)?.iter().try_for_each(|picture| refuse_input(picture, out))
}

/// Refuses to overwrite a store with something else.
pub(crate) fn refuse_store(out: &Path) -> Result<()> {
    if !out.is_file() || !Store::is_store(out)? {
        return Ok(());
    }
    Err(Error::invalid(
        out.display(),
        "is a store, which would be written over; name another file with --out",
    ))
}

/// Refuses to write over the file that is read.
pub(crate) fn refuse_input(input: &Path, out: &Path) -> Result<()> {
    if resolved(input) != resolved(out) {
        return Ok(());
    }
    Err(Error::invalid(out.display(), "is what is read; name another file with --out"))
}

/// One name per file, existing or not.
fn resolved(path: &Path) -> PathBuf {
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    path.canonicalize().unwrap_or_else(|_| match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) if !folder.as_os_str().is_empty() => resolved(folder).join(name),
        _ => absolute(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A manifest that names these color pictures, each with the depth of `d.png`.
    fn write_manifest(path: &Path, pictures: &[&str]) {
        let entry = |name: &&str| {
            format!(r#"{{"file_path":"{name}","depth_file_path":"d.png","transform_matrix":[]}}"#)
        };
        let entries: Vec<String> = pictures.iter().map(entry).collect();
        std::fs::write(path, format!(r#"{{"frames":[{}]}}"#, entries.join(","))).unwrap();
    }

    #[test]
    fn results_go_into_folders_that_are_there_and_pictures_into_folders_that_can_be_made() {
        let here = tempfile::tempdir().unwrap();
        let at = |name: &str| here.path().join(name);
        std::fs::write(at("taken"), "a file").unwrap();
        let said = |outcome: Result<()>| outcome.unwrap_err().to_string();
        assert!(check_file(&at("scene.ovl"), "scene.ovl").is_ok());
        assert!(check_file(&at("taken"), "scene.ovl").is_ok(), "results may be replaced");
        assert!(check_file(Path::new("scene.ovl"), "scene.ovl").is_ok());
        assert!(said(check_file(&at("none/scene.ovl"), "scene.ovl")).contains("does not exist"));
        assert!(said(check_file(&at("taken/scene.ovl"), "scene.ovl")).contains("does not exist"));
        assert!(
            said(check_file(here.path(), "scene.ovl"))
                .contains("is a folder; name a file in it, as in scene.ovl")
        );
        assert!(
            check_folder(here.path()).is_ok()
                && check_folder(&at("a/b")).is_ok()
                && check_folder(Path::new("a")).is_ok()
        );
        for place in ["taken", "taken/a/b"] {
            assert!(said(check_folder(&at(place))).contains("taken: is a file"), "{place}");
        }
    }

    #[test]
    fn no_result_replaces_a_manifest_or_a_picture_of_the_capture_it_is_made_from() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        std::fs::create_dir_all(here.join("novel")).unwrap();
        write_manifest(&here.join("transforms.json"), &["a/1.exr"]);
        write_manifest(&here.join("novel/transforms.json"), &["n.exr"]);
        write_manifest(&here.join("views.json"), &["v"]);
        let refused = |capture: &Path, out: &str| {
            refuse_capture_files(capture, Some(&here.join("views.json")), &here.join(out)).is_err()
        };
        for capture in [here, &here.join("transforms.json")] {
            for out in [
                "transforms.json",
                "novel/../transforms.json",
                "a/1.exr",
                "d.png",
                "novel/transforms.json",
                "novel/n.exr",
                "views.json",
                "v.png",
            ] {
                assert!(refused(capture, out), "{out}");
            }
            for out in ["scene.ovl", "a/2.exr", "novel/a/1.exr"] {
                assert!(!refused(capture, out), "{out}");
            }
        }
    }

    #[test]
    fn pictures_that_would_replace_their_truth_are_refused_whatever_the_path_is_called() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        std::fs::create_dir_all(here.join("novel/a")).unwrap();
        std::fs::create_dir(here.join("other")).unwrap();
        std::fs::write(here.join("novel/a/1.exr"), "the truth").unwrap();
        let manifest = here.join("novel/transforms.json");
        write_manifest(&manifest, &["a/1.exr", "a/2.png", "b/3"]);
        let refused = |out: &Path, name: &str| {
            let targets = [PicturePaths::below(out, name).unwrap()];
            let outcome = [&manifest, &here.join("novel")].map(|it| refuse_true_pictures(it, out, &targets));
            assert_eq!(outcome[0].is_err(), outcome[1].is_err());
            outcome[0].as_ref().err().map(ToString::to_string)
        };
        for name in ["a/1.exr", "./a/1", "a/2.png", "b/3"] {
            let said = refused(&here.join("other/../novel"), name).unwrap();
            assert!(said.contains("--out") && said.contains("novel"), "{said}");
            assert_eq!(refused(&here.join("other"), name), None);
        }
        assert_eq!(refused(&here.join("novel"), "a/11.exr"), None);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(here.join("novel"), here.join("link")).unwrap();
            assert!(refused(&here.join("link"), "a/1.exr").is_some());
        }
    }

    #[test]
    fn pictures_of_another_capture_are_not_painted_over_in_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        std::fs::create_dir(here.join("scene")).unwrap();
        write_manifest(&here.join("views.json"), &["v.exr"]);
        write_manifest(&here.join("scene/transforms.json"), &["a/1.exr"]);
        let out = here.join("scene");
        let refused = |name: &str| {
            let targets = [PicturePaths::below(&out, name).unwrap()];
            refuse_true_pictures(&here.join("views.json"), &out, &targets).is_err()
        };
        assert!(refused("a/1") && !refused("a/2"));
        std::fs::write(here.join("scene/transforms.json"), "no manifest").unwrap();
        assert!(!refused("a/1"));
    }
}
