//! Which pictures a film has: those of the camera path, or of a comparison those of the played frames.

use crate::app::model::state::State;
use crate::app::rooms::compare::model::comparison::CompareKey;
use crate::app::rooms::compare::model::vantage::CompareVantage;
use overlook_engine::render::Vantage;
use overlook_engine::render::film::FilmComparison;

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
