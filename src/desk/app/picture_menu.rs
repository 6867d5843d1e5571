//! The menu of a picture: ways out for what it shows.

use egui::{Button, Response};

use crate::app::model::command::ViewCommand;
use crate::app::model::purpose::{FigureOf, ShareCommand};
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::files::paths::no_figure;
use crate::ways_out::{Options, Way};

/// Opens by a right click on the picture of a view.
pub(crate) fn picture_menu_ui(response: &Response, of: FigureOf, state: &State, commands: &mut Commands) {
    response.context_menu(|ui| {
        let why_not = no_figure(state, of);
        let options = Options { way: Way::Figure, figure_of: of, ..state.share.options.clone() };
        let save = [ShareCommand::Change(Box::new(options)), ShareCommand::Open(Some(Way::Figure))];
        for (name, keys, does) in [
            ("Copy picture", "", vec![ShareCommand::CopyPicture(of)]),
            ("Copy figure", "Ctrl+Shift+F", vec![ShareCommand::CopyFigure(Some(of))]),
            ("Save figure…", "", save.to_vec()),
        ] {
            let button = ui.add_enabled(why_not.is_none(), Button::new(name).shortcut_text(keys));
            let button = button.accessible_name(name);
            if button.on_disabled_hover_text(why_not.unwrap_or_default()).clicked() {
                commands.extend(does.into_iter().map(Command::Share));
                ui.close();
            }
        }
        if of == FigureOf::Live {
            let name = "Copy the address of this view";
            let button = ui.add(Button::new(name).shortcut_text("Ctrl+L")).accessible_name(name);
            if button.clicked() {
                commands.push(Command::View(ViewCommand::CopyAddress));
                ui.close();
            }
        }
    });
}
