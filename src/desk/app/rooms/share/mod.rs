//! Everything that leaves the window: pages, splats, points, films and figures.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use std::sync::Arc;

use crate::app::model::look::Display;
use crate::app::model::picture::{ColorBy, HoleDisplay, LiveKey};
use crate::app::model::scene::OpenScene;
use crate::app::model::state::State;
use crate::app::rooms::compare::state::{CompareKey, CompareVantage};
use crate::ways_out::figure::FigureOf;
use crate::ways_out::{Needs, Options, Scope, Size, Way};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::render::Vantage;
use overlook_engine::render::film::FilmComparison;
use overlook_engine::samples::are_far_from_origin;
use overlook_engine::settings::{RenderSettings, Settings};

/// Pictures along a camera path as the live view shows them, where that is not the plain picture.
pub(crate) struct FilmLook {
    /// What the live view shows; its samples and its viewpoint are those of each picture in turn.
    pub key: LiveKey,
    /// What is asked how samples agree at each frame, where colors tell of that.
    pub scene: Arc<OpenScene>,
    pub scan: Option<Arc<PreparedScan>>,
    pub settings: Settings,
}

/// A comparison that is filmed.
pub(crate) struct ComparedFilm {
    pub how: FilmComparison,
    /// What is compared; its viewpoint is that of each picture in turn.
    pub key: CompareKey,
    /// Names of its sides.
    pub names: [String; 2],
}

/// The pictures of a camera path.
pub(crate) struct PathExport {
    /// The place of each.
    pub vantages: Vec<Vantage>,
    /// The comparison that they show; `None` where they show the samples.
    pub compared: Option<ComparedFilm>,
    /// How they look, where not plain.
    pub look: Option<FilmLook>,
    pub settings: RenderSettings,
    pub display: Display,
    /// Columns and rows of the pictures.
    pub size: [u32; 2],
    /// How many pictures a film shows a second; `None` for a folder.
    pub film_rate: Option<f64>,
    /// Text below every picture of a film; empty for none.
    pub caption: String,
    /// Whether a folder receives EXR of linear color and depth in place of PNG.
    pub linear: bool,
}

/// How long a film of a single frame from one viewpoint is, seconds.
const STILL_SECONDS: f32 = 4.0;

impl State {
    /// How many pictures a film of what is chosen in the dialog has.
    pub(crate) fn film_pictures(&self) -> usize {
        let is_compared = self.share.options.compares.is_some() && self.doc.scene.is_some();
        match self.doc.path.pictures() {
            0 if is_compared => self.filmed_frames().len(),
            along_path => along_path,
        }
    }

    /// The frames of a film from one viewpoint: those that are played; a single one for some seconds.
    fn filmed_frames(&self) -> Vec<usize> {
        let [first, last] = self.timeline.played(self.frame_count());
        if first < last {
            return (first..=last).collect();
        }
        vec![first; (STILL_SECONDS * self.timeline.frames_per_second).ceil() as usize]
    }

    /// The place of each picture of a film: along the camera path, or where there is none at every played frame.
    pub(crate) fn film_vantages(&self) -> Vec<Vantage> {
        let (size, frames) = (self.export_size(), self.frame_count());
        match self.live_camera(size) {
            Some(camera) if self.doc.path.pictures() == 0 && self.share.options.compares.is_some() => {
                let there = |frame| Vantage { camera: camera.clone(), frame };
                self.filmed_frames().into_iter().map(there).collect()
            }
            _ => self.doc.path.vantages(size, frames),
        }
    }

    /// What the live view shows in place of the plain picture of all samples, in words; `None` where it shows that.
    pub(crate) fn film_look(&self) -> Option<String> {
        let colored = ColorBy::ALL.iter().find(|(color_by, ..)| *color_by == self.live.color_by);
        let colored = colored.filter(|(color_by, ..)| *color_by != ColorBy::Picture);
        let hidden = self.doc.scene.as_ref().map_or(0, |scene| {
            (0..scene.cameras.len()).filter(|camera| !self.live.cameras.shows(*camera)).count()
        });
        let parts = [
            colored.map(|(_, name, _)| format!("colored by {}", name.to_lowercase())),
            (self.live.holes == HoleDisplay::Hatched).then(|| "with holes hatched".to_owned()),
            (hidden > 0).then(|| format!("without {}", counted(hidden, "hidden camera"))),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// What the live view shows, as it is painted at rest in so many columns and rows, with holes as on dark or light ground; `None`
    /// while it has no picture.
    pub(crate) fn live_key(&self, size: [u32; 2], dark: bool) -> Option<LiveKey> {
        let key = &self.doc.live_shown.as_ref()?.key;
        Some(LiveKey {
            vantage: Vantage { camera: self.live_camera(size)?, frame: self.timeline.frame },
            settings: self.settings.render.clone(),
            dark,
            in_motion: false,
            quality: None,
            per_coarse_pixel: f64::from(size[0]) / f64::from(self.live.size[0].max(1)),
            ..key.clone()
        })
    }

    /// How pictures along the camera path look, where not plain.
    pub(crate) fn filmed_look(&self) -> Option<FilmLook> {
        self.film_look()?;
        let key = LiveKey {
            color_by: self.live.color_by,
            holes: self.live.holes,
            cameras: self.live.cameras.clone(),
            display: self.display,
            ..self.live_key(self.export_size(), self.dark)?
        };
        let (scene, scan) = (self.doc.scene.clone()?, self.doc.scan.clone());
        Some(FilmLook { key, scene, scan, settings: self.settings.clone() })
    }

    /// The comparison that a film of what is chosen in the dialog shows, if it shows one.
    pub(crate) fn compared_film(&self) -> Option<ComparedFilm> {
        let (how, mut key) = (self.share.options.compares?, self.compare_key()?);
        if self.doc.path.pictures() > 0 {
            key.choice.from = CompareVantage::Live;
        }
        let names = key.choice.sides.map(|side| self.side_name(side));
        Some(ComparedFilm { how, key, names })
    }
}

impl State {
    /// The size of a way out, with the options of the dialog.
    pub(crate) fn share_size(&self, way: Way) -> Size {
        let Some(scene) = &self.doc.scene else { return Size::missing("nothing open") };
        let options = Options { way, ..self.share.options.clone() };
        if !self.is_whole_ready() && options.kind().needs == Needs::Samples {
            return Size::missing("once it is pruned");
        }
        let Some(facts) = self.share.facts else { return Size::missing("measuring…") };
        let scope = Scope {
            facts,
            cameras: scene.cameras.len(),
            frames: self.frame_count(),
            is_far: are_far_from_origin(&scene.cameras),
            frames_per_second: self.timeline.frames_per_second.into(),
            film_pictures: self.film_pictures(),
            film_size: self.export_size(),
            figure_size: if way == Way::Figure { self.size_in_figure(options.figure_of) } else { [0; 2] },
        };
        let mut size = (way.row().size)(&scope, &options);
        if options.kind().needs == Needs::Samples && self.cut_scene().is_some() {
            size.reason += &self.with_edits();
        }
        size
    }

    /// Columns and rows of the picture of a figure.
    fn size_in_figure(&self, of: FigureOf) -> [u32; 2] {
        let sides = match of {
            FigureOf::Live | FigureOf::Change => return self.figure_size(),
            FigureOf::Source => self.doc.source_shown.as_ref().map(|shown| shown.picture.size),
            FigureOf::Compared => self.compared_figure().map(|compared| {
                let [_, _, columns, rows] = compared.part();
                [columns, rows]
            }),
        };
        sides.unwrap_or_default().map(|side| side as u32)
    }
}
