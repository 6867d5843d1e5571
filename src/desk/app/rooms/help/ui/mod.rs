//! Help: the guide beside the window's work, the sheet of shortcuts, and what this program is.

pub(crate) mod entries;
pub(crate) mod palette;

use egui::{Grid, Id, Label, Modal, RichText, ScrollArea, Ui};

use crate::app::model::command::WindowCommand;
use crate::app::model::window::{HELP, HelpPage};
use crate::app::model::{self, Command, Commands, State};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::weak;
use overlook_engine::capture::known_sources;

/// The guide as it comes with the source code.
const GUIDE: &str = include_str!("../../../../../../GUIDE.md");

/// The page of help that is open.
pub(crate) fn help_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    match state.inspector.help {
        None => {}
        Some(HelpPage::Guide) => guide_ui(ctx, commands),
        Some(HelpPage::Sources) => sheet_ui(ctx, commands, "What opens", sources_ui),
        Some(HelpPage::Shortcuts) => sheet_ui(ctx, commands, "Keyboard and mouse shortcuts", shortcuts_ui),
        Some(HelpPage::About) => sheet_ui(ctx, commands, "About Overlook", |ui| about_ui(ui, state)),
    }
}

/// Columns and rows of the guide at first, points.
const GUIDE_SIZE: egui::Vec2 = egui::vec2(460.0, 520.0);

/// The guide is beside the views that it explains, and unlike the sheets it leaves the window usable: at the right, below the menus.
fn guide_ui(ctx: &egui::Context, commands: &mut Commands) {
    let mut open = true;
    let area = ctx.content_rect();
    let corner =
        area.right_top() + egui::vec2(-GUIDE_SIZE.x - 40.0, space::TOP_BAR + space::TOTALS + space::MEDIUM);
    egui::Window::new("Guide")
        .open(&mut open)
        .default_pos(corner)
        .default_size(GUIDE_SIZE)
        .max_height(area.height() - 120.0)
        .show(ctx, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                for block in blocks(GUIDE) {
                    block_ui(ui, block);
                }
            });
        });
    if !open {
        commands.push(Command::Window(WindowCommand::Help(None)));
    }
}

/// A piece of the guide.
#[derive(Debug, PartialEq, Eq)]
enum MarkdownBlock {
    Title(String),
    Heading(String),
    Item(String),
    Paragraph(String),
    /// Cells of a row of a table.
    Row(Vec<String>),
}

/// The guide cut into pieces, pictures left out: the window itself is what they show.
fn blocks(markdown: &str) -> Vec<MarkdownBlock> {
    let mut blocks: Vec<MarkdownBlock> = Vec::new();
    let mut goes_on = false;
    for line in markdown.lines() {
        let text = line.trim();
        let is_rule = text.starts_with('|') && text.chars().all(|letter| "|-: ".contains(letter));
        if text.is_empty() || text.starts_with("![") || is_rule {
            goes_on = false;
        } else if let Some(title) = text.strip_prefix("# ") {
            blocks.push(MarkdownBlock::Title(plain(title)));
        } else if let Some(heading) = text.strip_prefix("## ") {
            blocks.push(MarkdownBlock::Heading(plain(heading)));
        } else if text.starts_with('|') {
            blocks.push(MarkdownBlock::Row(
                text.trim_matches('|').split('|').map(|cell| plain(cell.trim())).collect(),
            ));
        } else if let Some(item) = text.strip_prefix("- ") {
            goes_on = true;
            blocks.push(MarkdownBlock::Item(plain(item)));
        } else if let (true, Some(MarkdownBlock::Item(before) | MarkdownBlock::Paragraph(before))) =
            (goes_on, blocks.last_mut())
        {
            *before = format!("{before} {}", plain(text));
        } else {
            goes_on = true;
            blocks.push(MarkdownBlock::Paragraph(plain(text)));
        }
    }
    blocks
}

/// A line without its marks of emphasis and code.
fn plain(text: &str) -> String {
    text.replace(['*', '`'], "")
}

fn block_ui(ui: &mut Ui, block: MarkdownBlock) {
    match block {
        MarkdownBlock::Title(title) => {
            ui.label(RichText::new(title).heading().size(19.0));
        }
        MarkdownBlock::Heading(heading) => {
            ui.add_space(space::MEDIUM);
            ui.heading(heading);
        }
        MarkdownBlock::Item(item) => {
            ui.horizontal_top(|ui| {
                ui.label("•");
                ui.add(Label::new(item).wrap());
            });
        }
        MarkdownBlock::Paragraph(text) => {
            ui.add(Label::new(text).wrap());
            ui.add_space(space::SMALL);
        }
        MarkdownBlock::Row(cells) => {
            let mut cells = cells.into_iter();
            let name = cells.next().unwrap_or_default();
            ui.horizontal_top(|ui| {
                ui.add_sized([110.0, 18.0], Label::new(RichText::new(name).strong()).wrap());
                ui.add(Label::new(cells.collect::<Vec<_>>().join("  ")).wrap());
            });
        }
    }
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
        if ui.button("Close").accessible_name("Close help").clicked() {
            commands.push(Command::Window(WindowCommand::Help(None)));
        }
    });
    if modal.should_close() {
        commands.push(Command::Window(WindowCommand::Help(None)));
    }
}

/// Width of the list of what opens, points.
const SOURCES: f32 = 560.0;

fn sources_ui(ui: &mut Ui) {
    ui.set_width(SOURCES.min(ui.available_width()));
    ui.label("A store (.ovl), or the folder of a capture, which is known by what it holds:");
    for source in known_sources() {
        ui.add(Label::new(format!("• {source}")).wrap());
    }
}

fn shortcuts_ui(ui: &mut Ui) {
    ui.horizontal_top(|ui| {
        // The first groups are the longest.
        let (left, right) = HELP.split_at(HELP.len() / 2);
        for groups in [left, right] {
            ui.vertical(|ui| {
                ui.spacing_mut().interact_size.y = SHORTCUT_ROW;
                for (heading, shortcuts) in groups {
                    weak(ui, *heading);
                    Grid::new(heading).num_columns(2).spacing([18.0, 4.0]).show(ui, |ui| {
                        for (keys, help) in *shortcuts {
                            ui.label(RichText::new(*keys).strong());
                            ui.label(*help);
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

fn about_ui(ui: &mut Ui, state: &State) {
    ui.set_width(380.0);
    ui.label(RichText::new(concat!("Version ", env!("CARGO_PKG_VERSION"))).strong());
    ui.add(Label::new(env!("CARGO_PKG_DESCRIPTION")).wrap());
    weak(ui, concat!("License: ", env!("CARGO_PKG_LICENSE")));
    ui.add_space(space::SMALL);
    let graphics = state.inspector.graphics.as_deref();
    ui.label(graphics.map_or_else(
        || "Window drawn with OpenGL; the scene is rendered by the CPU.".to_owned(),
        |adapter| format!("Graphics: {adapter}"),
    ));
    if graphics.is_some() {
        let memory = state.inspector.graphics_memory;
        let told = memory.map_or_else(|| "not told by its driver".to_owned(), model::bytes);
        ui.label(format!("GPU memory in use: {told}"));
    }
    let held = state.inspector.held_memory.iter();
    let held: Vec<String> = held.map(|(part, bytes)| format!("{part}: {}", model::bytes(*bytes))).collect();
    if !held.is_empty() {
        ui.label(format!("In memory: {}", held.join(", ")));
    }
    if let Some(shown) = &state.doc.live_shown {
        ui.label(format!("Last picture rendered by: {}", shown.picture.painter));
    }
    let instructions = overlook_engine::simd::widest();
    ui.label(RichText::new(format!("CPU instructions: {instructions}")).color(Tokens::in_ui(ui).text));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guide_is_cut_into_headings_items_rows_and_paragraphs() {
        let text = "# A walk\n\nTen *steps*\nlead.\n\n## 1. Open\n![p](x.png)\n- one\n  more\n- two\n\n| a | b |\n|---|---|\n| `c` | d |\n";
        let owned = |text: &str| text.to_owned();
        assert_eq!(
            blocks(text),
            [
                MarkdownBlock::Title(owned("A walk")),
                MarkdownBlock::Paragraph(owned("Ten steps lead.")),
                MarkdownBlock::Heading(owned("1. Open")),
                MarkdownBlock::Item(owned("one more")),
                MarkdownBlock::Item(owned("two")),
                MarkdownBlock::Row(vec![owned("a"), owned("b")]),
                MarkdownBlock::Row(vec![owned("c"), owned("d")]),
            ]
        );
    }
}
