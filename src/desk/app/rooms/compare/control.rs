//! Takes in comparisons, and the pictures of other programs that they show.

use egui::TextureOptions;

use crate::app::control::OverlookApp;
use crate::app::model::command::CompareCommand;
use crate::app::model::window::{DockView, NoticeKind};
use crate::app::rooms::compare::state::{
    CompareKey, CompareSide, CompareVantage, PictureDifference, PictureFolder, ShownComparison,
};

impl OverlookApp {
    pub(crate) fn apply_to_comparison(&mut self, command: CompareCommand) {
        let state = &mut self.state;
        match command {
            CompareCommand::Look(look) => {
                let before = &state.inspector.compare.choice;
                if (look.choice.sides, look.choice.from) != (before.sides, before.from) {
                    state.doc.compare_error = None;
                }
                state.inspector.compare = *look;
            }
            CompareCommand::ClosePictures(id) => state.close_pictures(|folder| folder.id == id),
        }
    }

    pub(crate) fn compared(&mut self, key: &CompareKey, outcome: Result<PictureDifference, String>) {
        let state = &mut self.state;
        state.doc.compare_error = outcome.as_ref().err().cloned();
        let Ok(comparison) = outcome else { return };
        let [left, right] = comparison.images.clone();
        let textures = [left, right, comparison.difference.clone()]
            .map(|image| self.ctx.load_texture("comparison", image, TextureOptions::NEAREST));
        let names = key.choice.sides.map(|side| state.side_name(side));
        state.doc.compared = Some(ShownComparison { choice: key.choice, names, comparison, textures });
    }

    /// Shows pictures of another program beside ours, from the first viewpoint that they show; opened again, they replace themselves.
    pub(crate) fn pictures_opened(&mut self, folder: PictureFolder) {
        let frame = self.state.timeline.frame;
        let state = &mut self.state;
        let path = |folder: &PictureFolder| folder.known().next().map(|pictures| pictures.folder.clone());
        state.close_pictures(|known| path(known) == path(&folder));
        let choice = &mut state.inspector.compare.choice;
        choice.sides = [CompareSide::Kept, CompareSide::Pictures(folder.id)];
        let shows_here = choice.from != CompareVantage::Live && folder.picture(choice.from, frame).is_ok();
        if let (false, Some(first)) = (shows_here, folder.first(frame)) {
            choice.from = first;
        }
        state.doc.compare_error = None;
        // What shows none of the viewpoints may be a camera's.
        let is_one_kind = folder.known().count() == 1;
        let left_over = folder.known().next().filter(|_| is_one_kind).and_then(|pictures| pictures.warning());
        let words = folder.words();
        state.doc.pictures.push(folder);
        self.dock.open(DockView::Compare);
        if let Some(warning) = left_over {
            self.state.warn_of_scene("Pictures without a viewpoint", warning);
        }
        self.state.inspector.log(NoticeKind::Done, words);
    }
}
