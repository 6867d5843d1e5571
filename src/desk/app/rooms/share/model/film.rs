//! Which pictures a film has: those of the camera path, or of a comparison those of the played frames.

use std::sync::Arc;

use crate::app::model::scene::OpenScene;
use crate::app::model::state::State;
use crate::app::rooms::compare::model::comparison::CompareKey;
use crate::app::rooms::compare::model::vantage::CompareVantage;
use crate::app::rooms::live::model::picture::{ColorBy, HoleDisplay, LiveKey};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::render::Vantage;
use overlook_engine::render::film::FilmComparison;
use overlook_engine::settings::Settings;

/// Pictures along a camera path as the live view shows them, where that is not the plain picture.
pub(crate) struct FilmLook {
    /// What the live view shows; its samples and its viewpoint are those of each picture in turn.
    pub key: LiveKey,
    /// What is asked how samples agree at each frame, where colors tell of that.
    pub agreement: Option<AgreementSource>,
}

/// What samples are asked of how they agree with other cameras.
pub(crate) struct AgreementSource {
    pub scene: Arc<OpenScene>,
    pub scan: Option<Arc<PreparedScan>>,
    pub settings: Settings,
}

/// A comparison that is filmed.
pub(crate) struct ComparedFilm {
    pub how: FilmComparison,
    /// What is compared; its viewpoint is that of each picture in turn.
    pub key: CompareKey,
    /// Of its sides.
    pub names: [String; 2],
}

/// How long a film of a single frame from one viewpoint is, seconds.
const STILL_SECONDS: f32 = 4.0;

impl State {
    /// How many pictures a film of what is chosen in the dialog has.
    pub(crate) fn film_pictures(&self) -> usize {
        let along_path = self.doc.path.pictures();
        if along_path > 0 || self.share.options.compares.is_none() || self.doc.scene.is_none() {
            return along_path;
        }
        self.filmed_frames().len()
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
            match self.live.holes {
                HoleDisplay::Filled => None,
                HoleDisplay::Hatched => Some("with holes hatched".to_owned()),
                HoleDisplay::Dimmed => Some("dimmed far from samples".to_owned()),
            },
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
        let key = self.live_key(self.export_size(), self.dark)?;
        let scene = self.doc.scene.as_ref()?;
        let is_agreement = self.live.color_by == ColorBy::Agreement && scene.capture().is_some();
        let agreement = is_agreement.then(|| AgreementSource {
            scene: scene.clone(),
            scan: self.doc.scan.clone(),
            settings: self.settings.clone(),
        });
        let (color_by, holes) = (self.live.color_by, self.live.holes);
        let key =
            LiveKey { color_by, holes, cameras: self.live.cameras.clone(), display: self.display, ..key };
        Some(FilmLook { key, agreement })
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
