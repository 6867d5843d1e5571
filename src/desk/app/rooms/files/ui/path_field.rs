//! A field for typing a path: for people who know it, and for systems without file dialogs.

use egui::{Id, Modal, RichText};

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::files::model::{FileCommand, Purpose, TypedPath};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, text_field_ui, weak};

/// The question before something is replaced.
fn replaced_words(typed: &TypedPath) -> String {
    let path = typed.text.trim();
    match typed.purpose {
        Purpose::ExportPictures | Purpose::ExportExr | Purpose::ExportPointsOfFrames => {
            format!(
                "Replace files in {path}? It holds files already; those of the same name will be replaced."
            )
        }
        _ => format!("Replace {path}? It exists already."),
    }
}

/// What the button does, and what kind of path it takes.
fn action_and_hint(purpose: Purpose) -> (&'static str, &'static str) {
    match purpose {
        Purpose::OpenFile | Purpose::OpenFolder => {
            ("Open", "folder of a capture, transforms.json, .ovl file, or the address of a view")
        }
        Purpose::SaveStore => ("Save", ".ovl file"),
        Purpose::SaveSettings | Purpose::SaveEdits => ("Save", ".toml file"),
        Purpose::SaveSession => ("Save", ".overlook file"),
        Purpose::SaveTable(_) => ("Save", ".csv, .md or .tex file"),
        Purpose::SavePicture => ("Save", ".png or .exr file"),
        Purpose::ExportPictures | Purpose::ExportExr | Purpose::ExportPointsOfFrames => ("Export", "folder"),
        Purpose::ExportPage => ("Export", ".html file"),
        Purpose::ExportSplats(_) => ("Export", "file of splats"),
        Purpose::ExportFigure => ("Export", ".pdf, .svg or .png file"),
        Purpose::SaveChart(_) => ("Save", ".pdf, .svg or .png file"),
        Purpose::ExportPoints => ("Export", ".ply file"),
        Purpose::ExportFilm => ("Export", ".mp4 file"),
        Purpose::SaveCameras | Purpose::SavePath => ("Save", "transforms.json"),
        Purpose::LoadPath => ("Load", "transforms.json"),
        Purpose::OpenPictures => ("Load", "folder of pictures"),
        Purpose::LoadSettings | Purpose::LoadEdits => ("Load", ".toml file"),
    }
}

/// The field, while it is open.
pub(crate) fn path_field_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let Some(typed) = &state.typed_path else { return };
    let purpose = typed.purpose;
    let (action, hint) = action_and_hint(purpose);
    let title = if action == "Open" { "Open a capture or a store" } else { purpose.title() };
    let modal = Modal::new(Id::unique("path field")).show(ctx, |ui| {
        ui.set_width(480.0);
        ui.heading(title);
        if let Some(reason) = &typed.reason {
            weak(ui, reason);
        }
        let base = std::path::Path::new(typed.text.trim());
        if !base.is_absolute()
            && !typed.text.trim().starts_with('~')
            && let Some(folder) = &typed.folder
        {
            note(ui, format!("In {}", folder.display()));
        }
        ui.add_space(space::MEDIUM);
        let mut text = typed.text.clone();
        let (changed, entered) = text_field_ui(ui, &mut text, hint, "Path");
        if changed {
            commands.push(Command::File(FileCommand::TypedPath(text)));
        }
        if entered {
            commands.push(Command::File(FileCommand::TakeTypedPath));
        }
        if typed.replaces {
            ui.label(RichText::new(replaced_words(typed)).color(Tokens::in_ui(ui).warning));
        }
        ui.add_space(space::MEDIUM);
        ui.horizontal(|ui| {
            let action = if typed.replaces { "Replace" } else { action };
            let take = ui.add_enabled(!typed.text.trim().is_empty(), egui::Button::new(action));
            if take.accessible_name(format!("{action} this path")).clicked() {
                commands.push(Command::File(FileCommand::TakeTypedPath));
            }
            if ui.button("Cancel").accessible_name("Cancel this path").clicked() {
                commands.push(Command::File(FileCommand::CloseTypedPath));
            }
        });
    });
    if modal.should_close() {
        commands.push(Command::File(FileCommand::CloseTypedPath));
    }
}
