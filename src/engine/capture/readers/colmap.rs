//! COLMAP's dense workspaces.
//!
//! Source: COLMAP's `image_undistorter` and `patch_match_stereo`: `images/`, `sparse/` (or `sparse/0/`) with cameras and images,
//! `stereo/depth_maps/NAME.geometric.bin` of planar z in the units of the poses, 0 for none, and `stereo/normal_maps/` of unit
//! vectors in the camera's space (x right, y down, z forward). Every image has its own size and lens; a map may be smaller than its
//! image. What differs: `.photometric.bin`, which is not filtered, is taken only if no `.geometric.bin` exists at all.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::views::{entry, mean_up, recording};
use crate::capture::colmap::{self, ColmapCamera, ColmapImage};
use crate::capture::pictures::PictureRows;
use crate::capture::transforms::{Keys, NormalSpaceName, PictureEntry, keys_of_colmap};
use crate::error::{Error, Result};
use crate::whole_file;

/// Largest file that is read: reconstructions of some 10,000 images.
const MAX_BYTES: u64 = 16 << 30;

/// How depth is computed of a reconstruction that has none.
const DENSE: &str = "there is no stereo/depth_maps, and thus no depth; compute it: colmap image_undistorter --image_path IMAGES --input_path MODEL --output_path dense, then colmap patch_match_stereo --workspace_path dense, and open dense";

/// COLMAP.
pub(super) const COLMAP: Reader = Reader {
    source: "COLMAP workspace",
    marks: "stereo/depth_maps beside sparse/ with cameras.bin or cameras.txt, also within dense/ (COLMAP)",
    stands_for_folder: |file| {
        ["cameras.bin", "images.bin", "cameras.txt", "images.txt", "points3D.bin"].contains(&file)
    },
    is_here: |place| !models(place).is_empty(),
    poses: "world to camera; camera x right, y down, z forward; units of the reconstruction, which are not metric",
    depth: "planar z in units of the poses, of stereo; 0 is no depth",
    lens: "every image has its own lens and size",
    read,
};

/// The parts of a workspace below the source's folder: each is `""`, or a path that ends in `/`.
struct ColmapWorkspace {
    /// The folder of `images/` and `stereo/`.
    root: String,
    /// The folder of the cameras and images.
    model: String,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let found = models(place);
    let with_depth = found.iter().filter(|it| place.join(&it.depth_maps()).is_dir());
    // The reconstruction with the most images' worth of bytes; the first of equal ones.
    let size = |it: &&ColmapWorkspace| {
        let images = ["images.bin", "images.txt"].map(|name| place.join(&format!("{}{name}", it.model)));
        images.iter().find_map(|path| path.metadata().ok()).map_or(0, |data| data.len())
    };
    let Some(workspace) = with_depth.clone().rev().max_by_key(size) else {
        return Err(Error::unsupported(place.path.display(), DENSE));
    };
    if with_depth.count() > 1 {
        let name = if workspace.root.is_empty() { "this folder" } else { &workspace.root };
        description.notes.push(format!("of several reconstructions the largest is read, {name}"));
    }
    let reconstruction = Reconstruction::read(place, &workspace.model)?;
    let frames = reconstruction.pictures(place, workspace, &mut description)?;
    let keys = Keys {
        depth_unit_scale_factor: Some(1.0),
        depth_kind: Some("planar_z".to_owned()),
        normal_space: Some(NormalSpaceName::Text("camera_opencv".to_owned())),
        up: Some(mean_up(&frames).unwrap_or(DVec3::NEG_Y).to_array()),
        // COLMAP reads the rows as they are stored.
        picture_orientation: Some(PictureRows::AsStored),
        noise_free: Some(false),
        ..Keys::default()
    };
    description.up_is_estimated = true;
    description.notes.push("up is the mean of the cameras' up, as COLMAP stores none".to_owned());
    recording(place, keys, frames, description, reconstruction.inputs)
}

impl ColmapWorkspace {
    fn depth_maps(&self) -> String {
        format!("{}stereo/depth_maps", self.root)
    }
}

/// Reconstructions at a place: the place itself may be the model, the workspace or what holds them.
fn models(place: &SourceFolder) -> Vec<ColmapWorkspace> {
    let numbered = |folder: &str| -> Vec<String> {
        let digits = (0..10).map(|number| format!("{folder}{number}/"));
        digits.filter(|name| place.join(name).is_dir()).collect()
    };
    let mut roots = vec![String::new(), "dense/".to_owned()];
    roots.extend(numbered("dense/"));
    roots.extend(numbered(""));
    let mut found = Vec::new();
    for root in roots {
        let mut below = vec![format!("{root}sparse/")];
        below.extend(numbered(&below[0]));
        for model in below.into_iter().filter(|model| holds_model(place, model)) {
            found.push(ColmapWorkspace { root: root.clone(), model });
        }
    }
    if holds_model(place, "") {
        // The place is the model: its workspace holds it, as sparse/ or sparse/0/, or is the place itself.
        let is_root = |root: &&&str| place.join(&format!("{root}images")).is_dir();
        let root = ["", "../", "../../"].iter().find(is_root).unwrap_or(&"../");
        found.push(ColmapWorkspace { root: (*root).to_owned(), model: String::new() });
    }
    found
}

fn holds_model(place: &SourceFolder, model: &str) -> bool {
    let has = |name: &str| place.join(&format!("{model}{name}")).is_file();
    [".bin", ".txt"].iter().any(|ending| has(&format!("cameras{ending}")) && has(&format!("images{ending}")))
}

/// What a model holds.
struct Reconstruction {
    /// By their numbers.
    cameras: BTreeMap<u64, ColmapCamera>,
    /// In the order of their names.
    images: Vec<ColmapImage>,
    /// The files of cameras and of images.
    inputs: Vec<PathBuf>,
}

impl Reconstruction {
    fn read(place: &SourceFolder, model: &str) -> Result<Self> {
        let is_binary =
            ["cameras.bin", "images.bin"].iter().all(|name| place.join(&format!("{model}{name}")).is_file());
        let ending = if is_binary { "bin" } else { "txt" };
        let paths = ["cameras", "images"].map(|name| place.join(&format!("{model}{name}.{ending}")));
        let [cameras, images] = [bytes_of(&paths[0])?, bytes_of(&paths[1])?];
        let shown = paths.each_ref().map(|path| path.display().to_string());
        let (cameras, mut images) = if is_binary {
            (colmap::cameras_of_bytes(&cameras, &shown[0])?, colmap::images_of_bytes(&images, &shown[1])?)
        } else {
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            (
                colmap::cameras_of_text(&text(&cameras), &shown[0])?,
                colmap::images_of_text(&text(&images), &shown[1])?,
            )
        };
        images.sort_by(|a, b| a.name.cmp(&b.name));
        let cameras = cameras.into_iter().map(|camera| (camera.id, camera)).collect();
        Ok(Self { cameras, images, inputs: paths.to_vec() })
    }

    /// The entries of images with a map of depth, a file and a pose. `description` gets the others.
    fn pictures(
        &self,
        place: &SourceFolder,
        workspace: &ColmapWorkspace,
        description: &mut Description,
    ) -> Result<Vec<PictureEntry>> {
        let maps = Maps::find(place, workspace, description);
        let mut frames = Vec::new();
        for image in &self.images {
            let Some(depth) = maps.of(place, "depth", &image.name) else {
                description.skip("without a map of depth", image.name.clone());
                continue;
            };
            let color = format!("{}images/{}", workspace.root, image.name);
            if !place.join(&color).is_file() {
                description.skip("that are not in images/", image.name.clone());
                continue;
            }
            let Some(pose) = image.world_from_camera() else {
                description.skip("without a pose", image.name.clone());
                continue;
            };
            let camera = self.cameras.get(&image.camera).ok_or_else(|| {
                let what = format!(
                    "image '{}' is of camera {}, which cameras does not list",
                    image.name, image.camera
                );
                Error::invalid(self.inputs[1].display(), what)
            })?;
            let normal = maps.of(place, "normal", &image.name);
            frames.push(picture(color, depth, normal, &pose, camera, &self.inputs[0])?);
        }
        Ok(frames)
    }
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    let length = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
    if length > MAX_BYTES {
        return Err(Error::invalid(
            path.display(),
            format!("{length} bytes are too many for a reconstruction"),
        ));
    }
    whole_file::read_all(path)
}

/// Which maps of a workspace are read.
struct Maps {
    root: String,
    /// `geometric` or `photometric`.
    kind: &'static str,
}

impl Maps {
    /// The filtered maps, or the others if none is filtered.
    fn find(place: &SourceFolder, workspace: &ColmapWorkspace, description: &mut Description) -> Self {
        let folder = place.join(&workspace.depth_maps());
        let kind = if holds_maps(&folder, ".geometric.bin") { "geometric" } else { "photometric" };
        if kind == "photometric" {
            let note = "the maps are not filtered (photometric); run colmap patch_match_stereo with --PatchMatchStereo.geom_consistency true for better ones";
            description.notes.push(note.to_owned());
        }
        Self { root: workspace.root.clone(), kind }
    }

    /// The map of an image, `what` being `depth` or `normal`.
    fn of(&self, place: &SourceFolder, what: &str, image: &str) -> Option<String> {
        let path = format!("{}stereo/{what}_maps/{image}.{}.bin", self.root, self.kind);
        place.join(&path).is_file().then_some(path)
    }
}

/// Whether a folder, or one in it, has a file that ends so.
fn holds_maps(folder: &Path, ending: &str) -> bool {
    let names = super::place::names_in(folder).unwrap_or_default();
    names.iter().any(|name| name.ends_with(ending))
        || names.iter().any(|name| !name.contains('.') && holds_maps(&folder.join(name), ending))
}

/// The entry of an image.
fn picture(
    color: String,
    depth: String,
    normal: Option<String>,
    pose: &DAffine3,
    camera: &ColmapCamera,
    path: &Path,
) -> Result<PictureEntry> {
    let own = keys_of_colmap(camera, path)?;
    Ok(PictureEntry { normal_file_path: normal, keys: own, ..entry(color, Some(depth), pose) })
}
