//! Carries out what concerns edits: selecting, deleting, and the list.

use std::path::PathBuf;

use crate::app::control::OverlookApp;
use crate::app::model::command::EditCommand;
use crate::app::model::window::NoticeKind;
use crate::app::model::{Message, Part, Undoable};
use crate::app::rooms::edits::state::{BRUSH_RADII, EditKey, EditedScene};
use overlook_engine::edits::{Action, Edit, EditList, Region};
use overlook_engine::plural::counted;
use overlook_engine::whole_file;

impl OverlookApp {
    pub(crate) fn apply_to_edits(&mut self, command: EditCommand) {
        let frame_number = self.state.frame_number();
        let edits = &mut self.state.doc.edits;
        let before = Undoable::Edits(edits.list.clone());
        let mut named = None;
        match command {
            EditCommand::Select(region) => {
                edits.selection = Some(edits.combined(region, edits.tools.combine));
            }
            EditCommand::Draw { region, combine, is_done: false } => edits.draft = Some((region, combine)),
            EditCommand::Draw { region, combine, is_done: true } => {
                edits.selection = Some(edits.combined(region, combine));
                edits.draft = None;
            }
            EditCommand::Mask { camera, stroke } => edits.mask(&camera, stroke),
            EditCommand::Reshape(region) => edits.selection = region,
            EditCommand::SelectNothing => {
                (edits.selection, edits.draft, edits.tools.tool) = (None, None, None);
            }
            EditCommand::Tools(mut tools) => {
                tools.radius = tools.radius.clamp(*BRUSH_RADII.start(), *BRUSH_RADII.end());
                tools.range = tools.range.map(|[first, last]| [first.min(last), last.max(first)]);
                edits.draft.take_if(|_| tools.tool != edits.tools.tool);
                edits.tools = tools;
            }
            EditCommand::Act(action) => {
                let edit = edits.edit_of_selection(action, frame_number.unwrap_or_default());
                if let Some(edit) = edit {
                    edits.list.edits.push(edit);
                    (edits.selection, edits.tools.tool) = (None, None);
                }
            }
            EditCommand::LeaveOut(cameras) => {
                let Some(scene) = &self.state.doc.scene else { return };
                let known = cameras.into_iter().filter_map(|camera| scene.cameras.get(camera));
                let names: Vec<String> = known.map(|camera| camera.name.clone()).collect();
                let what = match &names[..] {
                    [] => return,
                    [name] => name.clone(),
                    names => counted(names.len(), "camera"),
                };
                let edit = Edit::new(format!("Leave out {what}"), Action::LeaveOut, Region::Cameras(names));
                edits.list.edits.push(edit);
            }
            EditCommand::List(list, edit) => (edits.list, named) = (list, edit),
        }
        self.state.note_change(before, named.map(Part::EditName));
    }

    /// Takes in what edits leave, or why they cannot be applied.
    pub(crate) fn edited(&mut self, key: EditKey, edited: Result<Box<EditedScene>, String>) {
        let edits = &mut self.state.doc.edits;
        match edited {
            Ok(edited) => (edits.edited, edits.trouble) = (Some((key, *edited)), None),
            Err(trouble) => edits.trouble = Some(trouble),
        }
    }

    pub(crate) fn save_edits(&mut self, path: PathBuf) {
        let list = self.state.doc.edits.list.clone();
        self.save(path, move |path, _| {
            whole_file::write_all(path, list.to_toml())?;
            Ok(Message::EditsSaved { path: path.to_path_buf(), list })
        });
    }

    pub(crate) fn edits_saved(&mut self, path: &std::path::Path, list: EditList) {
        self.state.doc.edits.saved = list;
        self.state.notify(NoticeKind::Done, "Saved", path.display().to_string());
    }

    /// Takes in a list that was read: it is put in the place of the one that is there, which undo brings back.
    pub(crate) fn edits_loaded(&mut self, path: &std::path::Path, list: EditList) {
        let cameras = self.state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.cameras);
        let cut = self.state.report().map_or(&[][..], |report| &report.cut);
        let gone: Vec<String> = cut.iter().flat_map(|cut| cut.cameras.clone()).collect();
        let frames = self.state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.frame_numbers);
        let place = path.display().to_string();
        if let Err(error) = list.check(cameras, &gone, self.state.value_channels(), &place) {
            return self.state.notify(NoticeKind::Error, "Edits not opened", error.to_string());
        }
        for warning in list.without_effect(frames, &place) {
            self.state.notify(NoticeKind::Warning, "An edit does nothing here", warning);
        }
        self.state.take_edits(list);
        self.state.notify(NoticeKind::Done, "Edits opened", path.display().to_string());
    }
}
