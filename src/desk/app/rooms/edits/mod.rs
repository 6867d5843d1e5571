//! Edits: what is selected, deleted and brought back by hand.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use std::sync::Arc;

use crate::app::model::scene::Content;
use crate::app::model::state::State;
use crate::app::model::undo::Undoable;
use crate::app::rooms::edits::state::EditedScene;
use overlook_engine::edits::EditList;
use overlook_engine::plural::counted;
use overlook_engine::samples::SampleSet;

impl State {
    /// How many edits act, in words: `, with 1 edit`; empty where none does.
    pub(crate) fn with_edits(&self) -> String {
        let edits = self.doc.edits.list.edits.iter().filter(|edit| edit.is_on).count();
        if edits > 0 { format!(", with {}", counted(edits, "edit")) } else { String::new() }
    }

    /// Puts a list from a file in the place of the one that is there, which undo brings back.
    pub(crate) fn take_edits(&mut self, list: EditList) {
        let before = Undoable::Edits(std::mem::replace(&mut self.doc.edits.list, list.clone()));
        self.doc.edits.saved = list;
        self.note_change(before, None);
    }

    /// The number of the frame that is shown.
    pub(crate) fn frame_number(&self) -> Option<i64> {
        self.doc.scene.as_ref().and_then(|scene| scene.frame_numbers.get(self.timeline.frame).copied())
    }

    /// The samples that edits act on: those of the whole capture or store.
    pub(crate) fn samples_to_edit(&self) -> Option<&Arc<SampleSet>> {
        match self.content() {
            Some(Content::Store { samples, .. }) => Some(samples),
            _ => self.current_whole(),
        }
    }

    /// What edits and the selection last gave of these samples; `None` where nothing is edited or selected.
    pub(crate) fn edited(&self) -> Option<&EditedScene> {
        let (key, edited) = self.doc.edits.edited.as_ref().filter(|_| self.doc.edits.are_in_use())?;
        let is_of_these = self.samples_to_edit().is_some_and(|samples| Arc::ptr_eq(samples, &key.samples));
        is_of_these.then_some(edited)
    }

    /// The samples that the live view shows of what is edited: with the selection in its color, until another kind is chosen.
    pub(crate) fn edited_shown(&self) -> Option<&Arc<SampleSet>> {
        let (key, _) = self.doc.edits.edited.as_ref()?;
        let (before, now) = (key.selection.as_ref(), self.doc.edits.shown_selection());
        let is_same =
            before.map(state::words) == now.as_ref().map(state::words) || self.doc.edits.draft.is_some();
        self.edited().map(|edited| if is_same { &edited.shown } else { &edited.samples })
    }

    /// The edited scene, if it is of the list and the selection as they are now.
    pub(crate) fn edited_now(&self) -> Option<&EditedScene> {
        let (key, _) = self.doc.edits.edited.as_ref()?;
        let is_now = key.list == self.doc.edits.list && key.selection == self.doc.edits.shown_selection();
        self.edited().filter(|_| is_now)
    }

    /// What edits leave, where the list as it is was applied; `None` where nothing is edited.
    pub(crate) fn cut_scene(&self) -> Option<&EditedScene> {
        let (key, _) = self.doc.edits.edited.as_ref().filter(|_| !self.doc.edits.list.is_idle())?;
        self.edited().filter(|_| key.list == self.doc.edits.list)
    }

    /// The samples of that.
    pub(crate) fn edited_samples(&self) -> Option<&Arc<SampleSet>> {
        self.cut_scene().map(|edited| &edited.samples)
    }
}
