//! Small widgets that several areas share.

use std::collections::HashMap;

use egui::text::{LayoutJob, TextFormat};
use egui::{
    Align2, Button, Color32, ComboBox, FontId, Key, Painter, Pos2, Rect, RectAlign, Response, RichText,
    ScrollArea, Sense, TextEdit, TextStyle, TextureHandle, TextureId, Ui, Vec2, pos2, vec2,
};
use egui_material_icons::MaterialIcon;

use crate::app::model::camera_text::{CameraText, TextPart};
use crate::app::theme::{Tokens, space};
use crate::app::{camera_cues, colormap};
use overlook_engine::capture::Camera;

/// In less than this width a button beside tabs shows an icon instead of its name, since the tabs need the room.
pub(crate) const NARROW: f32 = 180.0;

/// Size of a button with an icon.
pub(crate) const ICON_BUTTON: Vec2 = Vec2::new(34.0, space::CONTROL);

/// A small button with an icon; `name` names it for screen readers, `help` explains it.
pub(crate) fn icon_button(ui: &mut Ui, icon: MaterialIcon, name: &str, help: &str) -> Response {
    bare_icon_button(ui, icon, name).on_hover_text(help)
}

/// Such a button without a tooltip.
pub(crate) fn bare_icon_button(ui: &mut Ui, icon: MaterialIcon, name: &str) -> Response {
    ui.scope(|ui| {
        ui.spacing_mut().button_padding = Vec2::new(8.0, 2.0);
        let button = Button::new(icon.rich_text().size(16.0)).min_size(ICON_BUTTON);
        ui.add(button).accessible_name(name)
    })
    .inner
}

/// A drop-down list of named choices with their explanations; gives the one that was picked.
pub(crate) fn choice_ui<T: Copy + PartialEq, S: AsRef<str>>(
    ui: &mut Ui,
    name: &str,
    current: T,
    choices: &[(T, S, S)],
    width: f32,
) -> Option<T> {
    let shown = choices.iter().find(|(value, ..)| *value == current);
    let mut picked = None;
    let response = ComboBox::from_id_salt(name)
        .width(width)
        .height(340.0)
        .truncate()
        .selected_text(shown.map_or("–", |(_, text, _)| text.as_ref()))
        .show_ui(ui, |ui| {
            for (value, text, help) in choices {
                let (text, help) = (text.as_ref(), help.as_ref());
                let option = ui.selectable_label(*value == current, text);
                let option = if help.is_empty() { option } else { option.on_hover_text(help) };
                if option.clicked() {
                    picked = Some(*value);
                }
            }
        })
        .response
        .accessible_name(name);
    if let Some((_, text, help)) = shown {
        let (text, help) = (text.as_ref(), help.as_ref());
        let hover = if help.is_empty() { format!("{name}: {text}") } else { format!("{name}: {help}") };
        response.on_hover_text(hover);
    }
    picked
}

/// Cameras as choices for [`choice_ui`], by their index.
pub(crate) fn camera_choices(cameras: &[Camera]) -> impl Iterator<Item = (usize, &str, &str)> {
    cameras.iter().enumerate().map(|(index, camera)| (index, camera.name.as_str(), ""))
}

/// Size of the text of choices in a row, points.
const SEGMENT_TEXT: f32 = 12.5;

/// Space between choices in a row, points.
const SEGMENT_GAP: f32 = 2.0;

/// Least and usual space on either side of the name of a choice, points.
const SEGMENT_PADDING: [f32; 2] = [2.0, 5.0];

/// Width of a row of choices with no space beside their names, points.
fn width_of_names<'a>(ui: &Ui, names: impl IntoIterator<Item = &'a str>) -> f32 {
    let font = FontId::proportional(SEGMENT_TEXT);
    let width = |name: &str| {
        ui.painter().layout_no_wrap(name.to_owned(), font.clone(), Color32::WHITE).size().x.ceil()
    };
    names.into_iter().map(|name| width(name) + SEGMENT_GAP).sum::<f32>() + 1.0
}

/// Usual width of a row of choices, points.
pub(crate) fn width_of_segments<T>(ui: &Ui, choices: &[(T, &'static str, &'static str)]) -> f32 {
    let names = width_of_names(ui, choices.iter().map(|(_, name, _)| *name));
    names + 2.0 * SEGMENT_PADDING[1] * choices.len() as f32
}

/// A row of choices, one of them on; gives the one that was clicked. `name` names the row for screen readers.
pub(crate) fn segments_ui<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    current: T,
    choices: impl IntoIterator<Item = (T, &'static str, &'static str)>,
) -> Option<T> {
    let mut clicked = None;
    ui.horizontal_wrapped(|ui| {
        let choices: Vec<_> = choices.into_iter().collect();
        // All fit into one row, where that can be.
        let left =
            ui.available_size_before_wrap().x - width_of_names(ui, choices.iter().map(|(_, text, _)| *text));
        let padding = (left / (2 * choices.len().max(1)) as f32).floor();
        let padding = padding.clamp(SEGMENT_PADDING[0], SEGMENT_PADDING[1]);
        ui.spacing_mut().item_spacing = Vec2::new(SEGMENT_GAP, 3.0);
        ui.spacing_mut().button_padding = Vec2::new(padding, 2.0);
        for (value, text, help) in choices {
            let button = Button::selectable(value == current, RichText::new(text).size(SEGMENT_TEXT));
            let button = ui.add(button).on_hover_text(help).accessible_name(format!("{name}: {text}"));
            if button.clicked() {
                clicked = Some(value);
            }
        }
    });
    clicked
}

/// Height from which on an empty area has room for its icon.
const ROOMY: f32 = 210.0;

/// What an area shows in place of contents: an icon, a title, a sentence, and ways out.
pub(crate) fn empty_ui(
    ui: &mut Ui,
    icon: MaterialIcon,
    title: &str,
    text: &str,
    ways_out: impl FnOnce(&mut Ui),
) {
    let tokens = Tokens::in_ui(ui);
    let area = ui.available_rect_before_wrap();
    let width = area.width().min(380.0);
    let is_low = area.height() < ROOMY;
    // Known from the picture before.
    let id = ui.scope_id().with(title);
    let height = ui.data(|data| data.get_temp(id)).unwrap_or(ROOMY);
    let column = Rect::from_center_size(area.center(), Vec2::new(width, height.min(area.height())));
    ui.scope_builder(egui::UiBuilder::new().max_rect(column), |ui| {
        let shown = ScrollArea::vertical().id_salt(title).auto_shrink(false).show(ui, |ui| {
            ui.vertical_centered(|ui| {
                if !is_low {
                    ui.label(icon.rich_text().size(34.0).color(tokens.text_weak));
                    ui.add_space(space::SMALL);
                }
                ui.heading(title);
                ui.label(RichText::new(text).color(tokens.text_weak));
                ui.add_space(space::MEDIUM);
                ui.vertical_centered(ways_out);
            });
        });
        ui.data_mut(|data| data.insert_temp(id, shown.content_size.y));
    });
    ui.allocate_rect(area, Sense::hover());
}

/// How far the wheel was turned, or two fingers were spread, points.
pub(crate) fn scrolled(ui: &Ui) -> f32 {
    ui.input(|input| input.smooth_scroll_delta().y + 200.0 * (input.zoom_delta() - 1.0))
}

/// Draws a texture over an area.
pub(crate) fn picture(painter: &Painter, texture: TextureId, area: Rect) {
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(texture, area, whole, Color32::WHITE);
}

/// Shows in the middle of an area that its picture is on the way.
pub(crate) fn waiting(ui: &Ui, area: Rect, size: f32) {
    egui::Spinner::new().paint_at(ui, Rect::from_center_size(area.center(), Vec2::splat(size)));
}

/// Explains a control beside it, so that what lies below stays in view: at its left, or where that has no room at its right, or above.
pub(crate) fn help_beside(control: &Response, help: String) {
    let mut tooltip = egui::Tooltip::for_enabled(control);
    let elsewhere = &[RectAlign::RIGHT, RectAlign::TOP];
    tooltip.popup = tooltip.popup.align(RectAlign::LEFT).align_alternatives(elsewhere);
    tooltip.show(|ui| ui.label(help));
}

/// A line of small text that explains.
pub(crate) fn note(ui: &mut Ui, text: impl Into<String>) -> Response {
    ui.label(RichText::new(text).small().color(Tokens::in_ui(ui).text_weak))
}

/// A line of text that explains.
pub(crate) fn weak(ui: &mut Ui, text: impl Into<String>) -> Response {
    ui.label(RichText::new(text).color(Tokens::in_ui(ui).text_weak))
}

/// A line of small text, cut off at the end of its room.
pub(crate) fn one_line(ui: &mut Ui, text: impl Into<String>, color: Color32) -> Response {
    ui.add(egui::Label::new(RichText::new(text).small().color(color)).truncate())
}

/// The sign of a camera beside its name.
pub(crate) fn dot(ui: &mut Ui, camera: usize) {
    let (dot, _) = ui.allocate_exact_size(Vec2::splat(10.0), Sense::hover());
    camera_cues::sign(ui.painter(), dot, camera);
}

/// A field for a line of text, which has the keyboard while nothing else has; `name` names it for screen readers. Gives whether
/// the text was changed, and whether Enter was pressed.
pub(crate) fn text_field_ui(ui: &mut Ui, text: &mut String, hint: &str, name: &str) -> (bool, bool) {
    // An identity of its own, so that widgets that come and go above the field do not take the keyboard from it.
    let field = TextEdit::singleline(text).id_salt(name);
    let field = field.desired_width(f32::INFINITY).margin(Vec2::new(8.0, 6.0));
    let field = ui.add(field.hint_text(hint)).accessible_name(name);
    let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if !entered && ui.memory(|memory| memory.focused().is_none()) {
        field.request_focus();
        select_stem(ui, field.id, text);
    }
    (field.changed(), entered)
}

/// Selects what is typed anew: the name up to its ending.
fn select_stem(ui: &Ui, field: egui::Id, text: &str) {
    let name = text.rfind(['/', '\\']).map_or(0, |at| at + 1);
    let end = text[name..].rfind('.').filter(|dot| *dot > 0).map_or(text.len(), |dot| name + dot);
    let count = |part: &str| egui::text::CCursor::new(part.chars().count());
    let range = egui::text::CCursorRange::two(count(&text[..name]), count(&text[..end]));
    let mut state = egui::text_edit::TextEditState::load(ui.ctx(), field).unwrap_or_default();
    state.cursor.set_char_range(Some(range));
    state.store(ui.ctx(), field);
}

/// The area of a picture, which is pointed at and dragged; `name` names it for screen readers.
pub(crate) fn canvas_ui(ui: &Ui, canvas: Rect, id: &str, name: &str) -> (Response, Painter) {
    let response = ui.interact(canvas, ui.scope_id().with(id), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    let painter = ui.painter_at(canvas);
    (response, painter)
}

/// Fills a canvas that its picture leaves open.
pub(crate) fn empty_canvas(ui: &Ui, painter: &Painter, canvas: Rect) {
    painter.rect_filled(canvas, f32::from(space::RADIUS), Tokens::in_ui(ui).canvas);
}

/// Pictures by their names: where they were drawn, and in which pass.
type DrawnPictures = HashMap<&'static str, (Rect, u64)>;

fn drawn_pictures<T>(ctx: &egui::Context, with: impl FnOnce(&mut DrawnPictures) -> T) -> T {
    ctx.data_mut(|data| with(data.get_temp_mut_or_default(egui::Id::unique("drawn pictures"))))
}

/// Notes where a picture is drawn whose pixels are pointed at, and behind which nothing is to be seen.
pub(crate) fn note_picture(ui: &Ui, area: Rect, name: &'static str) {
    let pass = ui.ctx().cumulative_pass_nr();
    drawn_pictures(ui.ctx(), |pictures| pictures.insert(name, (area, pass)));
}

/// Where a picture was drawn in this pass that is wanted by its name and place.
pub(crate) fn drawn_picture(ctx: &egui::Context, is_wanted: impl Fn(&str, Rect) -> bool) -> Option<Rect> {
    let pass = ctx.cumulative_pass_nr();
    drawn_pictures(ctx, |pictures| {
        let drawn = pictures.iter().find(|(name, (area, drawn))| *drawn == pass && is_wanted(name, *area));
        drawn.map(|(_, (area, _))| *area)
    })
}

/// Whether the pointer is over a picture whose pixels are pointed at: elsewhere no pixel is marked, unless it is pinned.
pub(crate) fn points_at_picture(ctx: &egui::Context) -> bool {
    let Some(pointer) = ctx.pointer_hover_pos() else { return false };
    let pass = ctx.cumulative_pass_nr();
    let is_under = |(area, drawn): &(Rect, u64)| drawn + 1 >= pass && area.contains(pointer);
    drawn_pictures(ctx, |pictures| pictures.values().any(is_under))
}

/// How far the color of a chip reaches beyond the letters, points.
const MARGIN: f32 = 2.0;

/// A text ready to be shown, wrapped or cut off by its label.
pub(crate) fn chips(
    ui: &Ui,
    text: &CameraText,
    cameras: &[Camera],
    style: &TextStyle,
    color: Color32,
) -> LayoutJob {
    let font = style.resolve(ui.style());
    let mut job = LayoutJob::default();
    for part in text.parts() {
        match part {
            TextPart::Words(words) => job.append(words, 0.0, TextFormat::simple(font.clone(), color)),
            TextPart::Camera(index) => {
                let Some(camera) = cameras.get(*index) else { continue };
                let background = camera_cues::color(*index);
                let name = TextFormat::simple(font.clone(), colormap::text_on(background));
                job.append(&camera.name, MARGIN, TextFormat { background, expand_bg: MARGIN, ..name });
                // Room for the margin on the other side.
                job.append("", MARGIN, TextFormat::simple(font.clone(), color));
            }
        }
    }
    job
}

/// What is folded away below a line that opens it; `of` is whose it is, `wanted` opens it.
pub(crate) fn fold_ui(ui: &mut Ui, name: &str, of: &str, wanted: bool, contents: impl FnOnce(&mut Ui)) {
    let header = egui::CollapsingHeader::new(RichText::new(name).color(Tokens::in_ui(ui).text_weak));
    header.id_salt((of, name)).open(wanted.then_some(true)).show_unindented(ui, contents);
}

pub(crate) fn heading_ui(ui: &mut Ui, name: &str) {
    ui.add_space(space::MEDIUM);
    ui.label(RichText::new(name).strong());
}

/// Columns and rows of a picture, points.
const VIEW_PICTURE: Vec2 = vec2(58.0, 39.0);

/// The small picture of a view that is called `name`; true where it was clicked.
pub(crate) fn view_picture_ui(ui: &mut Ui, shown: Option<&TextureHandle>, name: &str) -> bool {
    let (_, response) = ui.allocate_exact_size(VIEW_PICTURE, Sense::click());
    let name = format!("Go to {name}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    small_picture(ui, &response, shown);
    response.on_hover_text(name).clicked()
}

/// Draws a small picture whole in the middle of what responds, with a frame where it is pointed at or has the keyboard.
pub(crate) fn small_picture(ui: &Ui, response: &Response, shown: Option<&TextureHandle>) {
    let (room, tokens) = (response.rect, Tokens::in_ui(ui));
    ui.painter().rect_filled(room, 3.0, tokens.canvas);
    if let Some(texture) = shown {
        let size = texture.size_vec2();
        let scale = (room.width() / size.x).min(room.height() / size.y);
        picture(ui.painter(), texture.id(), Rect::from_center_size(room.center(), size * scale));
    }
    if response.hovered() || response.has_focus() {
        let stroke = egui::Stroke::new(2.0, tokens.accent);
        ui.painter().rect_stroke(room, 3.0, stroke, egui::StrokeKind::Inside);
    }
}

/// A line of text on the scrim.
pub(crate) fn plate(painter: &Painter, at: Pos2, align: Align2, text: &str, tokens: &Tokens) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(11.5), tokens.on_scrim);
    let area = align.anchor_size(at, galley.size() + vec2(8.0, 4.0));
    painter.rect_filled(area, 4.0, tokens.scrim);
    painter.galley(area.min + vec2(4.0, 2.0), galley, tokens.on_scrim);
}
