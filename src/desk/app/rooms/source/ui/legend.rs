//! What the colors of a picture mean: color bars and swatches.

use egui::{Align2, Color32, Label, Painter, Rect, Response, RichText, ScrollArea, Sense, Ui, pos2, vec2};

use crate::app::colormap::{dimmed, diverging, opaque, sequential};
use crate::app::model::command::SourceCommand;
use crate::app::model::look::titled_value;
use crate::app::model::picture::{
    ColorBy, HoleDisplay, Legend, Overlay, RATIO_RANGE, SourceKey, VIEW_DEPENDENCE_RANGE, ranked,
};
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::source::work::{UNKNOWN, empty_tiles};
use crate::app::theme::Tokens;
use crate::app::widgets::{one_line, plate};
use crate::app::{camera_cues, model};
use overlook_engine::grid::Grid;
use overlook_engine::preprocess::inspect::VISIBLE_STEPS;
use overlook_engine::render::{BACKGROUND_COLOR, MISSING_COLOR};
use overlook_engine::samples::TILE;

/// Height of a line of legend.
const LINE: f32 = 22.0;

/// Width that a swatch needs beside its name.
const SWATCH_WIDTH: f32 = 26.0;

/// Width of `others (25) 12.3 %`.
const MORE_WIDTH: f32 = 116.0;

/// Width of the legend of holes.
const HOLE_WIDTH: f32 = 220.0;

const RECORDED: &str = "As recorded. Choose an overlay above to see what is redundant.";

/// Of what a store shows where a camera stood.
const RENDERED: &str = "Kept pixels as recorded, the others as the kept ones show them from here.";

pub(crate) fn source_legend_ui(
    ui: &mut Ui,
    state: &State,
    key: &SourceKey,
    legend: &Legend,
    commands: &mut Commands,
) {
    let tokens = Tokens::in_ui(ui);
    line_ui(ui, |ui| match legend {
        Legend::Plain if key.overlay == Overlay::Normals => {
            one_line(ui, "Red, green and blue: the normal's x, y and z in world space.", tokens.text_weak);
        }
        Legend::Plain => {
            let recorded = if state.has_capture() { RECORDED } else { RENDERED };
            one_line(ui, recorded, tokens.text_weak);
        }
        Legend::Depth { near, far, without } => {
            let figure = |value: f32| model::significant(f64::from(value));
            bar_ui(ui, &format!("far {}", figure(*far)), &format!("near {}", figure(*near)), sequential);
            no_depth_ui(ui, f64::from(*without));
        }
        Legend::Ratio { unknown } => {
            ratio_ui(ui, "this camera denser", "other denser");
            let help = "No other camera shows the point.";
            share_ui(ui, dimmed(Color32::GRAY, UNKNOWN), "seen once", f64::from(*unknown), help);
        }
        Legend::Tiles(shares) => {
            swatch_ui(ui, dimmed(Color32::GRAY, UNKNOWN), &empty_tiles(shares));
            bar_ui(ui, "few kept", "all kept", sequential);
        }
        Legend::Classes { counts, invalid } => {
            let total = counts.iter().sum::<u64>() + invalid;
            let classes = if key.overlay == Overlay::Split { spans(tokens) } else { agreements(tokens) };
            classes_ui(ui, classes, Some((*counts, total)));
            no_depth_ui(ui, share(*invalid, total));
        }
        Legend::ViewDependence { visible, alike, unknown } => {
            let total = visible + alike + unknown;
            bar_ui(ui, "0", &format!("{VIEW_DEPENDENCE_RANGE:.0} of 255"), sequential);
            let differs = format!("noticeable {}", model::percent(*visible, total));
            ui.label(RichText::new(differs).small()).on_hover_text(format!(
                "Differs by {VISIBLE_STEPS:.0} or more of 255 steps: the eye sees two colors.",
            ));
            let help = "No other camera shows the point about as finely.";
            share_ui(ui, dimmed(Color32::GRAY, UNKNOWN), "seen once", share(*unknown, total), help);
        }
        Legend::Winners { kept, lost_to, dropped, invalid } => {
            let total = kept + dropped + invalid + lost_to.iter().sum::<u64>();
            let label = RichText::new(format!("kept {}", model::percent(*kept, total)));
            ui.label(label.small()).on_hover_text("Kept pixels show their own picture.");
            no_depth_ui(ui, share(*invalid, total));
            let help = "Dropped without a witness: contradicted by other cameras, or edge-blended.";
            share_ui(ui, tokens.hole, "dropped", share(*dropped, total), help);
            winners_ui(ui, state, lost_to, total, commands);
        }
    });
}

/// The share of `part` in `whole`, 0 to 1.
fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// A color with its share of the picture, 0 to 1, where it has any.
fn share_ui(ui: &mut Ui, color: Color32, name: &str, share: f64, help: &str) {
    if share > 0.0 {
        swatch_ui(ui, color, &format!("{name} {:.1} %", 100.0 * share)).on_hover_text(help);
    }
}

/// The gray of pixels without depth.
fn no_depth_ui(ui: &mut Ui, share: f64) {
    let help = "The camera recorded no depth here: these pixels take part in nothing.";
    share_ui(ui, Tokens::in_ui(ui).invalid, "no depth", share, help);
}

/// Three classes of samples, in the colors of both views: color, name and, where the name does not say it, what it means.
type Classes = [(Color32, &'static str, &'static str); 3];

/// How samples agree with other cameras.
fn agreements(tokens: &Tokens) -> Classes {
    [
        (
            tokens.confirmed,
            "confirmed",
            "Another camera sees the surface where this one has it, and no majority contradicts it.",
        ),
        (
            tokens.contradicted,
            "contradicted",
            "More cameras see a surface behind this one than see this one, its own camera counted among the latter. \
             A cross-camera check by majority drops such samples.",
        ),
        (tokens.alone, "alone", "No other camera confirms it, and no majority contradicts it."),
    ]
}

/// For how long samples are stored.
fn spans(tokens: &Tokens) -> Classes {
    [
        (tokens.static_over_time, "all frames", ""),
        (tokens.lasting, "several", ""),
        (tokens.moving, "this frame", ""),
    ]
}

/// Classes, where that is known each with its count of all pixels.
fn classes_ui(ui: &mut Ui, classes: Classes, counts: Option<([u64; 3], u64)>) {
    for (index, (color, name, help)) in classes.into_iter().enumerate() {
        let share = counts.map(|(counts, total)| model::percent(counts[index], total));
        let entry = swatch_ui(ui, color, &with_share(name, share.as_ref()));
        if !help.is_empty() {
            entry.on_hover_text(help);
        }
    }
}

/// A name, with a share behind it where that is known.
fn with_share(name: &str, share: Option<&String>) -> String {
    share.map_or_else(|| name.to_owned(), |share| format!("{name} {share}"))
}

/// Cameras with the share of pixels that each won, most first; *others* are those that the picture shows as such, too. While the pointer
/// is on a name, the picture shows that camera alone.
fn winners_ui(ui: &mut Ui, state: &State, won_by: &[u64], total: u64, commands: &mut Commands) {
    let cameras = state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.cameras);
    let (ranked, named) = ranked(won_by);
    let entry = |camera: usize| {
        let name = &cameras.get(camera)?.name;
        Some((camera, format!("{name} {}", model::percent(won_by[camera], total))))
    };
    let entries: Vec<_> = ranked.iter().filter_map(|camera| entry(*camera)).collect();
    let hovered = cameras_ui(ui, &entries, named, 0.0, |others| {
        let count: u64 = others.iter().map(|(camera, _)| won_by[*camera]).sum();
        format!(" {}", model::percent(count, total))
    });
    if hovered != state.doc.isolated {
        commands.push(Command::Source(SourceCommand::Isolate(hovered)));
    }
}

/// The first `most` of some cameras with words beside each, as far as they fit before the last `reserved` points of the line, and a list
/// of the others that opens at a click; `of_others` is said of these. Gives the camera under the pointer.
fn cameras_ui(
    ui: &mut Ui,
    entries: &[(usize, String)],
    most: usize,
    reserved: f32,
    of_others: impl Fn(&[(usize, String)]) -> String,
) -> Option<usize> {
    let font = egui::TextStyle::Small.resolve(ui.style());
    let mut room = ui.available_width() - reserved - MORE_WIDTH;
    let fits = |(_, name): &&(usize, String)| {
        let galley = ui.painter().layout_no_wrap(name.clone(), font.clone(), Color32::PLACEHOLDER);
        room -= galley.size().x + SWATCH_WIDTH;
        room >= 0.0
    };
    let (shown, others) = entries.split_at(entries.iter().take(most).take_while(fits).count());
    let mut hovered = None;
    let mut camera_ui = |ui: &mut Ui, (camera, words): &(usize, String)| {
        if entry_ui(ui, words, |painter, area| camera_cues::sign(painter, area, *camera)).hovered() {
            hovered = Some(*camera);
        }
    };
    for entry in shown {
        camera_ui(ui, entry);
    }
    if !others.is_empty() {
        let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
        ui.painter().rect_filled(rect, 2.0, Tokens::in_ui(ui).text_weak);
        let label = format!("others ({}){}", others.len(), of_others(others));
        let button = egui::Button::new(RichText::new(label).small()).small();
        egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
            ScrollArea::vertical().max_height(300.0).show_rows(ui, LINE, others.len(), |ui, rows| {
                for entry in &others[rows] {
                    ui.horizontal(|ui| camera_ui(ui, entry));
                }
            });
        });
    }
    hovered
}

pub(crate) fn live_legend_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    line_ui(ui, |ui| {
        match state.live.color_by {
            ColorBy::Picture => {}
            ColorBy::Camera => {
                let cameras = state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.cameras);
                let entries: Vec<_> =
                    cameras.iter().enumerate().map(|(index, camera)| (index, camera.name.clone())).collect();
                cameras_ui(ui, &entries, entries.len(), HOLE_WIDTH, |_| String::new());
            }
            ColorBy::Agreement if state.has_capture() => classes_ui(ui, agreements(tokens), None),
            ColorBy::Agreement => {
                let text = "A store does not record agreement; open its capture for that.";
                one_line(ui, text, tokens.text_weak);
            }
            ColorBy::Span => classes_ui(ui, spans(tokens), None),
            ColorBy::SamplingRate => ratio_ui(ui, "denser than pixels", "coarser"),
            ColorBy::Value => value_ui(ui, state),
        }
        holes_ui(ui, state);
    });
}

/// The colors of the value that is shown, between the ends of its range.
fn value_ui(ui: &mut Ui, state: &State) {
    let Some((_, channel)) = state.display.values.channel_of(state.value_channels()) else { return };
    let Ok(colors) = state.display.values.colors(channel) else {
        one_line(ui, "The range of the value has no width.", Tokens::in_ui(ui).warning);
        return;
    };
    let [low, high] = colors.range().map(|end| model::significant(f64::from(end)));
    let low = format!("{} {low}", titled_value(channel));
    bar_ui(ui, &low, &high, |share| opaque(colors.color(colors.value_at(share))));
    swatch_ui(ui, opaque(MISSING_COLOR), "no value");
    swatch_ui(ui, opaque(BACKGROUND_COLOR), "background");
}

/// What pixels are that no sample reached, and their share of the picture.
fn holes_ui(ui: &mut Ui, state: &State) {
    let shares = state.doc.live_shown.as_ref().map(|shown| {
        let pixels = shown.picture.size.iter().product::<usize>().max(1) as u64;
        let (holes, sky) = (shown.picture.stats.holes, shown.picture.sky_holes);
        let sky = if state.holes_shown() == HoleDisplay::Hatched { 0 } else { sky.min(holes) };
        [model::percent(holes - sky, pixels), model::percent(sky, pixels)]
    });
    let named = |name: &str| with_share(name, shares.as_ref().map(|[unseen, _]| unseen));
    match state.holes_shown() {
        HoleDisplay::Filled => {
            let name = named("filled (invented)");
            // Among the picture's own colors it has none of its own.
            let response = match state.live.color_by {
                ColorBy::Picture => ui.label(RichText::new(name).small()),
                _ => swatch_ui(ui, Color32::GRAY, &name),
            };
            response.on_hover_text(
                "No sample reached these pixels. Their colors are continued from the background; H shows them.",
            );
            if let Some([_, sky]) = shares.as_ref().filter(|[_, sky]| !sky.starts_with("0.0 ")) {
                ui.label(RichText::new(format!("background {sky}")).small()).on_hover_text(
                    "No sample reached these pixels either: they show what cameras saw infinitely far in that direction.",
                );
            }
        }
        HoleDisplay::Hatched => {
            swatch_ui(ui, Tokens::in_ui(ui).hole_stripe, &named("hole: no sample reached it"));
        }
    }
}

/// The kept share of each tile, where tiles are large enough on the screen to read it.
pub(crate) fn tile_shares(
    painter: &Painter,
    picture: Rect,
    size: egui::Vec2,
    shares: &Grid<f32>,
    tokens: &Tokens,
) {
    let tile = picture.width() / size.x * TILE as f32;
    if tile < 30.0 {
        return;
    }
    for tile_y in 0..shares.height() {
        for tile_x in 0..shares.width() {
            let center = picture.min + vec2(tile_x as f32 + 0.5, tile_y as f32 + 0.5) * tile;
            if !painter.clip_rect().contains(center) {
                continue;
            }
            let text = format!("{:.0}", shares[(tile_x, tile_y)] * 100.0);
            plate(painter, center, Align2::CENTER_CENTER, &text, tokens);
        }
    }
}

fn line_ui(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), LINE), Sense::hover());
    ui.scope_builder(egui::UiBuilder::new().max_rect(rect).id_salt("legend"), |ui| {
        ui.horizontal_centered(contents);
    });
}

/// A color with its name beside it.
pub(crate) fn swatch_ui(ui: &mut Ui, color: Color32, name: &str) -> Response {
    entry_ui(ui, name, |painter, area| {
        painter.rect_filled(area, 2.0, color);
    })
}

/// What is painted into a small square, with words beside it.
fn entry_ui(ui: &mut Ui, words: &str, paint: impl FnOnce(&Painter, Rect)) -> Response {
    ui.spacing_mut().item_spacing.x = 5.0;
    let (area, square) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
    paint(ui.painter(), area);
    let response = ui.add(Label::new(RichText::new(words).small()).sense(Sense::hover()));
    ui.add_space(6.0);
    response.union(square)
}

/// A color bar, `width` wide, between the names of its ends.
pub(crate) fn bar(ui: &mut Ui, low: &str, high: &str, width: f32, color: impl Fn(f32) -> Color32) {
    ui.label(RichText::new(low).small());
    let (rect, _) = ui.allocate_exact_size(vec2(width, 10.0), Sense::hover());
    gradient(ui.painter(), rect, color);
    ui.label(RichText::new(high).small());
}

/// A color bar as wide as the line has room for.
fn bar_ui(ui: &mut Ui, low: &str, high: &str, color: impl Fn(f32) -> Color32) {
    let width = (ui.available_width() - 150.0).clamp(60.0, 180.0);
    bar(ui, low, high, width, color);
}

/// The diverging bar, with the ratios at its ends and middle.
fn ratio_ui(ui: &mut Ui, low: &str, high: &str) {
    ui.label(RichText::new(low).small());
    let (rect, response) = ui.allocate_exact_size(vec2(120.0, LINE), Sense::hover());
    let bar = Rect::from_min_max(rect.min + vec2(0.0, 1.0), pos2(rect.right(), rect.top() + 9.0));
    gradient(ui.painter(), bar, |position| diverging(position * 2.0 - 1.0));
    let font = egui::FontId::proportional(10.0);
    let weak = Tokens::in_ui(ui).text_weak;
    let end = 2.0_f32.powf(RATIO_RANGE);
    for (position, align, label) in [
        (rect.left(), Align2::LEFT_BOTTOM, format!("1/{end:.0}")),
        (rect.center().x, Align2::CENTER_BOTTOM, "r = 1".to_owned()),
        (rect.right(), Align2::RIGHT_BOTTOM, format!("{end:.0}")),
    ] {
        ui.painter().text(pos2(position, rect.bottom()), align, label, font.clone(), weak);
    }
    response.on_hover_text(
        "r compares two sampling rates; the scale is logarithmic, and r = 1 means equally dense.",
    );
    ui.label(RichText::new(high).small());
}

fn gradient(painter: &Painter, rect: Rect, color: impl Fn(f32) -> Color32) {
    let steps = 48;
    let step = rect.width() / steps as f32;
    for i in 0..steps {
        let left = rect.left() + step * i as f32;
        // Half a point of overlap closes the seams that anti-aliasing would leave.
        let part = Rect::from_min_max(pos2(left, rect.top()), pos2(left + step + 0.5, rect.bottom()));
        painter.rect_filled(part.intersect(rect), 0.0, color((i as f32 + 0.5) / steps as f32));
    }
}
