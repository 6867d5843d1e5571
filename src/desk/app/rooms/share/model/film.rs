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
}

impl State {
    /// How many pictures a film of what is chosen in the dialog has.
    pub(crate) fn film_pictures(&self) -> usize {
        let along_path = self.doc.path.pictures();
        if along_path > 0 || self.share.options.compares.is_none() || self.doc.scene.is_none() {
            return along_path;
        }
        let [first, last] = self.timeline.played(self.frame_count());
        last - first + 1
    }

    /// The place of each picture of a film: along the camera path, or where there is none at every played frame.
    pub(crate) fn film_vantages(&self) -> Vec<Vantage> {
        let (size, frames) = (self.export_size(), self.frame_count());
        let [first, last] = self.timeline.played(frames);
        match self.live_camera(size) {
            Some(camera) if self.doc.path.pictures() == 0 => {
                (first..=last).map(|frame| Vantage { camera: camera.clone(), frame }).collect()
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
        Some(ComparedFilm { how, key })
    }
}
