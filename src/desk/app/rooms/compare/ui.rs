//! Two pictures from one viewpoint: wiped over each other, flipped, beside each other, or as their difference. One zoom for both.

use egui::{Align, Align2, Key, Layout, Painter, Rect, Response, Sense, Stroke, Ui, Vec2, vec2};
use egui_material_icons::icons::{ICON_ADD_PHOTO_ALTERNATE, ICON_COMPARE, ICON_LOCK, ICON_LOCK_OPEN};

use crate::app::colormap::opaque;
use crate::app::model::command::{CompareCommand, FileCommand};
use crate::app::model::picture::PictureZoom;
use crate::app::model::purpose::{FigureOf, Purpose};
use crate::app::model::{Command, Commands, Content, State};
use crate::app::picture_menu::picture_menu_ui;
use crate::app::rooms::compare::state::{
    CLASSES, CompareInView, CompareLook, CompareMeasure, CompareMode, CompareVantage, PictureDifference,
    ShownComparison,
};
use crate::app::rooms::compare::{about_pixel, figures};
use crate::app::rooms::source::ui::legend;
use crate::app::theme::{Tokens, space};
use crate::app::widgets;
use crate::app::widgets::{choice_ui, empty_ui, icon_button, one_line, scrolled, segments_ui, waiting};

/// Height of the lines below the picture.
const FOOTER: f32 = 48.0;

/// Widths of the lists: in a view that is wide enough, and at least.
const LIST_WIDTH: f32 = 140.0;
const SHORTEST_LIST: f32 = 60.0;
/// Width of the button of other programs' pictures.
const PICTURES_WIDTH: f32 = 38.0;

const BAR_WIDTH: f32 = 150.0;

pub(crate) fn compare_view_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let before = &state.inspector.compare;
    let mut look = before.clone();
    header_ui(ui, state, &mut look, commands);
    let area = ui.available_rect_before_wrap();
    let canvas = Rect::from_min_max(area.min, area.max - vec2(0.0, FOOTER));
    let pointed = if let Some(trouble) = &state.doc.compare_error {
        ui.scope_builder(egui::UiBuilder::new().max_rect(canvas), |ui| {
            empty_ui(ui, ICON_COMPARE, "These two cannot be compared here", trouble, |_| {});
        });
        None
    } else {
        canvas_ui(ui, canvas, state, &mut look, commands)
    };
    ui.allocate_rect(canvas, Sense::hover());
    footer_ui(ui, state, &mut look, pointed);
    if look != *before {
        commands.push(Command::Compare(CompareCommand::Look(Box::new(look))));
    }
}

/// What is compared above, how below: rows that wrap break each other apart in a narrow view.
fn header_ui(ui: &mut Ui, state: &State, look: &mut CompareLook, commands: &mut Commands) {
    ui.horizontal(|ui| {
        // What is left beside the button, with a gap after each list.
        let gap = ui.spacing().item_spacing.x;
        let width = ((ui.available_width() - PICTURES_WIDTH) / 3.0 - gap).clamp(SHORTEST_LIST, LIST_WIDTH);
        let sides = state.compare_sides();
        for (side, name) in look.choice.sides.iter_mut().zip(["Left side", "Right side"]) {
            list_ui(ui, name, side, &sides, width);
        }
        list_ui(ui, "From", &mut look.choice.from, &places(state), width);
        pictures_menu_ui(ui, state, commands);
    });
    look.mode = segments_ui(ui, "Compare by", look.mode, CompareMode::ALL).unwrap_or(look.mode);
    if look.mode == CompareMode::Difference
        && let Some(measure) = segments_ui(ui, "Difference in", look.choice.measure, CompareMeasure::ALL)
    {
        // A locked range is one of the other unit.
        (look.choice.measure, look.choice.range) = (measure, None);
    }
}

/// A list of such a width: one as wide as its text would push the others out of the view.
fn list_ui<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    chosen: &mut T,
    choices: &[(T, String, String)],
    width: f32,
) {
    let layout = Layout::left_to_right(Align::Center);
    ui.allocate_ui_with_layout(vec2(width, space::CONTROL), layout, |ui| {
        *chosen = choice_ui(ui, name, *chosen, choices, width).unwrap_or(*chosen);
    });
}

fn pictures_menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let button = egui::Button::new(ICON_ADD_PHOTO_ALTERNATE.rich_text().size(16.0));
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
        if ui.button("Open folder of pictures…").on_hover_text(PICTURES).clicked() {
            commands.push(Command::File(FileCommand::AskPath(Purpose::OpenPictures)));
        }
        for folder in &state.doc.pictures {
            if ui.button(format!("Close {}", folder.name())).on_hover_text(folder.words()).clicked() {
                commands.push(Command::Compare(CompareCommand::ClosePictures(folder.id)));
            }
        }
    });
    response.on_hover_text(PICTURES).accessible_name("Pictures of other programs");
}

const PICTURES: &str = "Compare with pictures that another program made of the same viewpoints. Where their folder has a \
                        transforms.json, it says where each was taken; else each has its viewpoint's own name.";

fn places(state: &State) -> Vec<(CompareVantage, String, String)> {
    let mut places =
        vec![(CompareVantage::Live, "Live view".to_owned(), "The viewpoint of the live view.".to_owned())];
    let Some(scene) = &state.doc.scene else { return places };
    let Content::Capture { truth, .. } = &scene.content else { return places };
    places.extend(scene.cameras.iter().enumerate().map(|(index, camera)| {
        let help = "Viewed from this camera, rendered from the samples of all others.".to_owned();
        (CompareVantage::HoldOut(index), format!("Camera {}, held out", camera.name), help)
    }));
    let known = truth.iter().filter(|view| view.truth.is_some()).enumerate();
    places.extend(known.map(|(index, view)| {
        let help = format!("A viewpoint whose true picture is known: {}.", view.file_path);
        (CompareVantage::Truth(index), format!("True picture {}", index + 1), help)
    }));
    places
}

/// The two pictures; gives the pixel under the pointer.
fn canvas_ui(
    ui: &mut Ui,
    canvas: Rect,
    state: &State,
    look: &mut CompareLook,
    commands: &mut Commands,
) -> Option<[usize; 2]> {
    let tokens = Tokens::in_ui(ui);
    let (response, painter) = widgets::canvas_ui(ui, canvas, "comparison", "Comparison");
    widgets::empty_canvas(ui, &painter, canvas);
    let Some(compared) = &state.doc.compared else {
        waiting(ui, canvas, 28.0);
        return None;
    };
    picture_menu_ui(&response, FigureOf::Compared, state, commands);
    let size = Vec2::from(compared.comparison.images[0].size.map(|side| side as f32));
    let flipped = is_pressed(ui, &response) && look.mode == CompareMode::Flip
        || ui.input(|input| input.key_down(Key::X));
    let parts = parts(look, flipped);
    let areas: Vec<Rect> = parts.iter().map(|(_, shares)| area_of(look.mode, canvas, *shares)).collect();
    draw(&painter, canvas, compared, look, &parts);
    if !is_of(compared, look) {
        painter.rect_filled(canvas, f32::from(space::RADIUS), tokens.scrim);
        waiting(ui, canvas, 28.0);
    }
    let corners = canvas.shrink(6.0);
    let corners = [(corners.left_top(), Align2::LEFT_TOP), (corners.right_top(), Align2::RIGHT_TOP)];
    for ((texture, _), (at, align)) in parts.iter().zip(corners) {
        let words = compared.names.get(*texture).map_or("Difference", String::as_str);
        widgets::plate(&painter, at, align, words, tokens);
    }
    // Side by side, the pointer is over one of the two.
    let pointer = response.hover_pos();
    let under = areas.iter().find(|area| pointer.is_some_and(|at| area.contains(at))).or(areas.first());
    let picture = look.part.placed(size, *under.unwrap_or(&canvas));
    look.in_view = in_view(look, size, canvas, areas[0], flipped).unwrap_or(look.in_view);
    move_ui(ui, &response, canvas, picture, look);
    let at = response.hover_pos().filter(|at| picture.contains(*at))?;
    let at = (at - picture.min) / picture.size() * size;
    Some([at.x as usize, at.y as usize])
}

/// Whether the pictures are those of the choice; if not, they are being computed.
fn is_of(compared: &ShownComparison, look: &CompareLook) -> bool {
    (compared.choice.sides, compared.choice.from) == (look.choice.sides, look.choice.from)
}

/// What is drawn: which of left, right and difference, and the shares of the width between which.
fn parts(look: &CompareLook, flipped: bool) -> Vec<(usize, [f32; 2])> {
    match look.mode {
        CompareMode::Difference => vec![(2, [0.0, 1.0])],
        CompareMode::Flip | CompareMode::Wipe if flipped => vec![(1, [0.0, 1.0])],
        CompareMode::Flip => vec![(0, [0.0, 1.0])],
        CompareMode::Wipe => vec![(0, [0.0, look.wipe]), (1, [look.wipe, 1.0])],
        CompareMode::Beside => vec![(0, [0.0, 0.5]), (1, [0.5, 1.0])],
    }
}

/// The area that a picture between two shares of the width is fitted into: the whole canvas for pictures over each other.
fn area_of(mode: CompareMode, canvas: Rect, [from, to]: [f32; 2]) -> Rect {
    let column = |share: f32| canvas.left() + canvas.width() * share;
    if mode == CompareMode::Beside {
        Rect::from_x_y_ranges(column(from)..=column(to), canvas.y_range())
    } else {
        canvas
    }
}

/// What is seen of pictures of `size`; the first is fitted into `area`. `None` where that has no room.
fn in_view(look: &CompareLook, size: Vec2, canvas: Rect, area: Rect, flipped: bool) -> Option<CompareInView> {
    let picture = Some(look.part.placed(size, area)).filter(Rect::is_positive)?;
    let share = |at: egui::Pos2| ((at - picture.min) / picture.size()).to_pos2();
    let seen = picture.intersect(area);
    let line = canvas.left() + canvas.width() * look.wipe;
    Some(CompareInView {
        part: Rect::from_min_max(share(seen.min), share(seen.max)),
        line: (line - picture.left()) / picture.width(),
        flipped,
    })
}

fn draw(
    painter: &Painter,
    canvas: Rect,
    compared: &ShownComparison,
    look: &CompareLook,
    parts: &[(usize, [f32; 2])],
) {
    let size = Vec2::from(compared.comparison.images[0].size.map(|side| side as f32));
    let column = |share: f32| canvas.left() + canvas.width() * share;
    for (texture, [from, to]) in parts {
        let clip = Rect::from_x_y_ranges(column(*from)..=column(*to), canvas.y_range());
        let picture = look.part.placed(size, area_of(look.mode, canvas, [*from, *to]));
        let texture = compared.textures[*texture].id();
        widgets::picture(&painter.with_clip_rect(clip), texture, picture);
    }
    for (_, [from, _]) in parts.iter().skip(1) {
        for (width, color) in [(3.0, egui::Color32::BLACK), (1.5, egui::Color32::WHITE)] {
            painter.vline(column(*from), canvas.y_range(), Stroke::new(width, color));
        }
    }
}

/// Whether the primary button is held on the pictures: the other one opens their menu.
fn is_pressed(ui: &Ui, response: &Response) -> bool {
    response.is_pointer_button_down_on() && ui.input(|input| input.pointer.primary_down())
}

/// Drags the line of the wipe, or the picture; the wheel zooms to the pointer.
fn move_ui(ui: &Ui, response: &Response, canvas: Rect, picture: Rect, look: &mut CompareLook) {
    if response.double_clicked() {
        look.part = PictureZoom::default();
        return;
    }
    let shifts = response.dragged_by(egui::PointerButton::Middle)
        || response.dragged_by(egui::PointerButton::Secondary)
        || ui.input(|input| input.modifiers.shift)
        || look.mode != CompareMode::Wipe;
    if response.dragged() && shifts {
        look.part = look.part.shifted(response.drag_delta() / picture.size());
    } else if is_pressed(ui, response)
        && look.mode == CompareMode::Wipe
        && let Some(pointer) = response.interact_pointer_pos()
    {
        look.wipe = ((pointer.x - canvas.left()) / canvas.width()).clamp(0.0, 1.0);
    }
    let scroll = scrolled(ui);
    if let Some(pointer) = response.hover_pos().filter(|_| scroll != 0.0) {
        look.part = look.part.scrolled(scroll, (pointer - picture.min) / picture.size());
    }
}

fn footer_ui(ui: &mut Ui, state: &State, look: &mut CompareLook, pointed: Option<[usize; 2]>) {
    let tokens = Tokens::in_ui(ui);
    let compared = state.doc.compared.as_ref().filter(|_| state.doc.compare_error.is_none());
    let Some(compared) = compared else { return };
    let comparison = &compared.comparison;
    ui.horizontal(|ui| {
        if look.mode == CompareMode::Difference {
            bar_ui(ui, comparison);
            let locked = look.choice.range.is_some();
            let (icon, name) =
                if locked { (ICON_LOCK, "Fit the range") } else { (ICON_LOCK_OPEN, "Lock the range") };
            let help = "A locked range stays when the pictures change, so that colors can be compared.";
            if icon_button(ui, icon, name, help).clicked() {
                look.choice.range = if locked { None } else { Some(comparison.range) };
            }
        } else {
            let hint = match look.mode {
                CompareMode::Wipe => {
                    "Drag the line. Wheel to zoom, Shift + drag to pan; hold X for the right side."
                }
                CompareMode::Beside => "Wheel to zoom, drag to pan: both move alike.",
                _ => "Hold X, or the mouse button, for the right side.",
            };
            one_line(ui, hint, tokens.text_weak);
        }
    });
    let words = pointed.and_then(|at| about_pixel(comparison, at)).unwrap_or_else(|| figures(comparison));
    let (words, color) = if is_of(compared, look) {
        (words, tokens.text)
    } else {
        let [left, right] = &compared.names;
        (format!("{left} and {right}: {words}"), tokens.text_weak)
    };
    one_line(ui, words, color);
}

/// What the colors of the map mean.
fn bar_ui(ui: &mut Ui, comparison: &PictureDifference) {
    let (measure, [low, high]) = (comparison.measure, comparison.measure.ends(comparison.range));
    if measure == CompareMeasure::Class {
        for (class, name) in CLASSES {
            legend::swatch_ui(ui, opaque(class.color()), name);
        }
        ui.label(egui::RichText::new(format!("full color: {high}")).small());
    } else {
        legend::bar(ui, &low, &high, BAR_WIDTH, |position| measure.color(position));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holding_the_key_shows_the_right_side_everywhere_whether_wiped_or_flipped() {
        for mode in [CompareMode::Wipe, CompareMode::Flip] {
            let look = CompareLook { mode, ..CompareLook::default() };
            assert_eq!(parts(&look, true), [(1, [0.0, 1.0])], "{mode:?}");
            assert_eq!(parts(&look, false)[0].0, 0, "{mode:?}");
        }
        let look = CompareLook { mode: CompareMode::Difference, ..CompareLook::default() };
        assert_eq!(parts(&look, true), [(2, [0.0, 1.0])]);
    }
}
