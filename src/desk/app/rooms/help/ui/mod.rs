//! Help: the guide beside the window's work, the sheet of shortcuts, and what this program is.

mod entries;
pub(crate) mod palette;

use std::sync::{Arc, Mutex, PoisonError};

use egui::{Grid, Id, Label, Modal, RichText, ScrollArea, Ui};
use egui_commonmark::{CommonMarkCache, CommonMarkViewer};

use crate::app::model::command::WindowCommand;
use crate::app::model::window::{HelpPage, NoticeKind, SHORTCUTS};
use crate::app::model::{self, Command, Commands, State};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::weak;
use overlook_engine::capture::known_sources;

/// Pages as they come with the source code, by the names that links call them. The first is the guide.
const PAGES: [(&str, &str); 5] = [
    ("GUIDE.md", include_str!("../../../../../../GUIDE.md")),
    ("EXPORT.md", include_str!("../../../../../../EXPORT.md")),
    ("EDITING.md", include_str!("../../../../../../EDITING.md")),
    ("SCIENCE.md", include_str!("../../../../../../SCIENCE.md")),
    ("CAPTURES.md", include_str!("../../../../../../CAPTURES.md")),
];

/// The page of help that is open.
pub(crate) fn help_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    match state.inspector.help {
        None => {}
        Some(HelpPage::Guide(page)) => guide_ui(ctx, page, commands),
        Some(HelpPage::Sources) => sheet_ui(ctx, commands, "What opens", sources_ui),
        Some(HelpPage::Shortcuts) => sheet_ui(ctx, commands, "Keyboard and mouse shortcuts", shortcuts_ui),
        Some(HelpPage::Log) => sheet_ui(ctx, commands, "Log", |ui| log_ui(ui, state)),
        Some(HelpPage::About) => sheet_ui(ctx, commands, "About Overlook", |ui| about_ui(ui, state)),
    }
}

/// Columns and rows of the guide at first, points.
const GUIDE_SIZE: egui::Vec2 = egui::vec2(460.0, 520.0);

/// The guide is beside the views that it explains, and unlike the sheets it leaves the window usable: at the right, below the menus. A
/// link to another page opens that page in its place.
fn guide_ui(ctx: &egui::Context, page: usize, commands: &mut Commands) {
    let mut open = true;
    let area = ctx.content_rect();
    let corner =
        area.right_top() + egui::vec2(-GUIDE_SIZE.x - 40.0, space::TOP_BAR + space::TOTALS + space::MEDIUM);
    let text = shown(PAGES.get(page).map_or("", |(_, text)| text), page > 0);
    // It knows where headings are from one frame to the next.
    let cache = ctx.data_mut(|data| {
        data.get_temp_mut_or_default::<Arc<Mutex<CommonMarkCache>>>(Id::unique("guide")).clone()
    });
    let mut cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
    let links = text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    links.filter(|link| link.contains(".md")).for_each(|link| cache.add_link_hook(link));
    egui::Window::new("Guide")
        .open(&mut open)
        .default_pos(corner)
        .default_size(GUIDE_SIZE)
        .max_height(area.height() - 120.0)
        .show(ctx, |ui| {
            ScrollArea::vertical().id_salt(page).auto_shrink(false).show(ui, |ui| {
                CommonMarkViewer::new().enable_scroll_to_heading(true).show(ui, &mut cache, &text);
            });
        });
    let clicked = cache.link_hooks().iter().find(|(_, is_clicked)| **is_clicked).map(|(link, _)| link);
    let opened = clicked.and_then(|link| PAGES.iter().position(|(name, _)| link.starts_with(name)));
    if opened.is_some() || !open {
        commands.push(Command::Window(WindowCommand::Help(opened.map(HelpPage::Guide))));
    }
}

/// A page as the window shows it: without pictures, which the window itself is, and with tables as lists, whose texts wrap. `leads_back`
/// is whether a link to the guide is above it.
fn shown(page: &str, leads_back: bool) -> String {
    let mut lines = if leads_back { vec!["[Guide](GUIDE.md)\n".to_owned()] } else { Vec::new() };
    for line in page.lines().filter(|line| !line.starts_with("![")) {
        if line.starts_with("|-") {
            // Names of columns are above it.
            lines.pop();
        } else if let Some((name, rest)) = line.strip_prefix("| ").and_then(|row| row.split_once(" | ")) {
            lines.push(format!("- {name}: {}", rest.trim_end_matches(" |").replace(" | ", "; ")));
        } else {
            lines.push(line.to_owned());
        }
    }
    lines.join("\n")
}

/// Height that the title, the button and the edges of a page take, and what stays of the window around it, points.
const AROUND_SHEET: f32 = 130.0;

/// Height of a row of the shortcuts, points.
const SHORTCUT_ROW: f32 = 17.0;

/// A page that is read and closed.
fn sheet_ui(ctx: &egui::Context, commands: &mut Commands, title: &str, contents: impl FnOnce(&mut Ui)) {
    let modal = Modal::new(Id::unique("help")).show(ctx, |ui| {
        ui.heading(title);
        ui.add_space(space::SMALL);
        // The button stays in sight however low the window is.
        let height = ctx.content_rect().height() - AROUND_SHEET;
        let scroll = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
        scroll.auto_shrink([true, true]).show(ui, contents);
        ui.add_space(space::MEDIUM);
        ui.button("Close").accessible_name("Close help").clicked()
    });
    if modal.inner || modal.should_close() {
        commands.push(Command::Window(WindowCommand::Help(None)));
    }
}

/// Width of a page of lines of text, points.
const TEXT_WIDTH: f32 = 560.0;

fn sources_ui(ui: &mut Ui) {
    ui.set_width(TEXT_WIDTH.min(ui.available_width()));
    ui.label("A store (.ovl), or the folder of a capture, which is known by what it holds:");
    for source in known_sources() {
        ui.add(Label::new(format!("• {source}")).wrap());
    }
}

fn shortcuts_ui(ui: &mut Ui) {
    ui.horizontal_top(|ui| {
        // The first groups are the longest.
        let groups: Vec<&str> = SHORTCUTS.split("\n\n").collect();
        let (left, right) = groups.split_at(groups.len() / 2);
        for groups in [left, right] {
            ui.vertical(|ui| {
                ui.spacing_mut().interact_size.y = SHORTCUT_ROW;
                for group in groups {
                    let (heading, shortcuts) = group.split_once('\n').unwrap_or((group, ""));
                    weak(ui, heading);
                    Grid::new(heading).num_columns(2).spacing([18.0, 4.0]).show(ui, |ui| {
                        for (keys, help) in shortcuts.lines().filter_map(|line| line.split_once(": ")) {
                            ui.label(RichText::new(keys).strong());
                            ui.label(help);
                            ui.end_row();
                        }
                    });
                    ui.add_space(space::MEDIUM);
                }
            });
            ui.add_space(space::LARGE);
        }
    });
}

/// What happened, in order.
fn log_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    ui.set_width(TEXT_WIDTH.min(ui.available_width()));
    let log = &state.inspector.log;
    let Some(first) = log.front() else {
        weak(ui, "Work that is done and trouble that is met appear here.");
        return;
    };
    ui.spacing_mut().item_spacing.y = 2.0;
    for line in log {
        ui.horizontal_top(|ui| {
            let seconds = line.at.duration_since(first.at).as_secs_f64();
            ui.label(RichText::new(format!("{seconds:8.2} s")).monospace().color(tokens.text_weak));
            let color = match line.kind {
                NoticeKind::Error => tokens.error,
                NoticeKind::Warning => tokens.warning,
                NoticeKind::Done => tokens.text,
            };
            ui.add(Label::new(RichText::new(&line.text).color(color)).wrap().selectable(true));
        });
    }
}

fn about_ui(ui: &mut Ui, state: &State) {
    ui.set_width(380.0);
    ui.label(RichText::new(concat!("Version ", env!("CARGO_PKG_VERSION"))).strong());
    ui.add(Label::new(env!("CARGO_PKG_DESCRIPTION")).wrap());
    weak(ui, concat!("License: ", env!("CARGO_PKG_LICENSE")));
    ui.add_space(space::SMALL);
    if let Some(adapter) = &state.inspector.graphics {
        ui.label(format!("Graphics: {adapter}"));
        let memory = state.inspector.graphics_memory;
        let told = memory.map_or_else(|| "not told by its driver".to_owned(), model::bytes);
        ui.label(format!("GPU memory in use: {told}"));
    } else {
        ui.label("Window drawn with OpenGL; the scene is rendered by the CPU.");
    }
    let held = state.inspector.held_memory.iter();
    let held: Vec<String> = held.map(|(part, bytes)| format!("{part}: {}", model::bytes(*bytes))).collect();
    if !held.is_empty() {
        ui.label(format!("In memory: {}", held.join(", ")));
    }
    if let Some(shown) = &state.doc.live_shown {
        ui.label(format!("Last picture rendered by: {}", shown.picture.painter));
    }
    ui.label(format!("CPU instructions: {}", overlook_engine::simd::widest()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_shown_as_lists_and_pictures_are_left_out() {
        let page = "# A walk\n\n![p](x.png)\n| a | b | c |\n|---|---|---|\n| `c` | d | e |\n";
        assert_eq!(shown(page, false), "# A walk\n\n- `c`: d; e");
        assert!(shown(page, true).starts_with("[Guide](GUIDE.md)\n\n# A walk"));
    }
}
