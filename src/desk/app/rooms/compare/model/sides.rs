//! The sides of a comparison, which may be pictures of another program.

use super::comparison::{CompareLook, CompareSide};
use crate::app::model::state::State;
use crate::app::rooms::files::model::picture_folder::PictureFolder;

impl State {
    /// Name of a side of a comparison.
    pub(crate) fn side_name(&self, side: CompareSide) -> String {
        if let CompareSide::Pictures(id) = side {
            let folder = self.doc.pictures.iter().find(|folder| folder.id == id);
            return folder.map(PictureFolder::name).unwrap_or_default();
        }
        let known = CompareSide::ALL.iter().find(|(of, ..)| *of == side);
        known.map(|(_, name, _)| (*name).to_owned()).unwrap_or_default()
    }

    /// Closes pictures of other programs; sides that showed them show what they did at first.
    pub(crate) fn close_pictures(&mut self, closes: impl Fn(&PictureFolder) -> bool) {
        self.doc.pictures.retain(|folder| !closes(folder));
        let first = CompareLook::default().choice.sides;
        for (side, first) in self.inspector.compare.choice.sides.iter_mut().zip(first) {
            if let CompareSide::Pictures(id) = *side
                && self.doc.pictures.iter().all(|folder| folder.id != id)
            {
                *side = first;
            }
        }
    }
}
