//! What became of all pixels, as bars that are always in view: what is kept, and for each reason what is dropped.

use egui::{Align2, Color32, Rect, Response, Sense, TextStyle, Ui, pos2, vec2};

use crate::app::model;
use crate::app::theme::Tokens;
use overlook_engine::preprocess::diagnostics::PixelAccount;

/// Least width of a bar with its name, points. Narrower ones are drawn as one bar of all.
const LEAST_WIDTH: f32 = 78.0;

/// Between two bars, points.
const GAP: f32 = 10.0;

/// Width of the one bar, points: what is narrower says nothing.
const LEAST_WHOLE: f32 = 90.0;

/// Height of a bar, points.
const BAR: f32 = 7.0;

/// A share of all pixels.
struct Cause {
    name: &'static str,
    pixels: u64,
    color: Color32,
    help: &'static str,
}

/// Every share, in the order in which pixels are lost; they add up to all pixels.
fn causes(account: &PixelAccount, tokens: &Tokens) -> Vec<Cause> {
    let cause = |name, pixels, color, help| Cause { name, pixels, color, help };
    let mut all = vec![
        cause("Kept", account.kept, tokens.moving, "Samples that stay."),
        cause(
            "Repeated",
            account.repeated,
            tokens.static_over_time,
            "The same camera shows the same in other frames: one sample is stored for all of them.",
        ),
        cause(
            "Redundant",
            account.redundant,
            tokens.accent,
            "A kept sample of another camera shows the same point at least as well.",
        ),
        cause(
            "No depth",
            account.without_depth,
            tokens.text_weak,
            "Pixels without depth say nothing about the scene.",
        ),
        cause("Blended", account.mixed, tokens.warning, "Color or depth is blended across an edge."),
        cause(
            "Contradicted",
            account.contradicted,
            tokens.error,
            "More cameras look past the point than confirm it.",
        ),
    ];
    if account.cut > 0 {
        all.push(cause("Cut by hand", account.cut, tokens.text, "An edit deletes it."));
    }
    all
}

/// The bars in the room that is left; nothing where that is too little.
pub(crate) fn causes_ui(ui: &mut Ui, account: &PixelAccount) -> Option<Response> {
    let tokens = Tokens::in_ui(ui);
    let all = causes(account, tokens);
    let room = ui.available_size();
    let each = (room.x + GAP) / all.len() as f32 - GAP;
    if room.x < LEAST_WHOLE {
        return None;
    }
    let (area, response) = ui.allocate_exact_size(room, Sense::click());
    let parts: Vec<String> =
        all.iter().map(|cause| format!("{} {}", cause.name, percent(cause, account))).collect();
    let name = format!("What became of all pixels: {}", parts.join(", "));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    if each < LEAST_WIDTH {
        whole_bar(ui, area, &all, account);
        return Some(response.on_hover_text(format!("{name}. Click for the rules.")));
    }
    let pointer = response.hover_pos();
    let mut help = None;
    for (nth, cause) in all.iter().enumerate() {
        let left = area.left() + nth as f32 * (each + GAP);
        let place = Rect::from_min_size(pos2(left, area.top()), vec2(each, area.height()));
        bar(ui, place, cause, account, tokens);
        if pointer.is_some_and(|pointer| place.expand(GAP / 2.0).contains(pointer)) {
            help = Some(format!(
                "{} {}: {} Click for the rules.",
                cause.name,
                percent(cause, account),
                cause.help
            ));
        }
    }
    Some(match help {
        Some(help) => response.on_hover_text(help),
        None => response,
    })
}

fn percent(cause: &Cause, account: &PixelAccount) -> String {
    model::percent(cause.pixels, account.pixels)
}

fn share(cause: &Cause, account: &PixelAccount) -> f32 {
    cause.pixels as f32 / account.pixels.max(1) as f32
}

/// A name, its share in words, and a bar as long as the share.
fn bar(ui: &Ui, place: Rect, cause: &Cause, account: &PixelAccount, tokens: &Tokens) {
    let font = TextStyle::Small.resolve(ui.style());
    let painter = ui.painter();
    let name = painter.text(place.left_top(), Align2::LEFT_TOP, cause.name, font.clone(), tokens.text_weak);
    let figure = pos2(place.left(), name.bottom() + 1.0);
    let figure = painter.text(figure, Align2::LEFT_TOP, percent(cause, account), font, tokens.text);
    let rail = Rect::from_min_size(pos2(place.left(), figure.bottom() + 2.0), vec2(place.width(), BAR));
    painter.rect_filled(rail, 2.0, tokens.raised);
    let length = if cause.pixels > 0 { (rail.width() * share(cause, account)).max(1.5) } else { 0.0 };
    painter.rect_filled(Rect::from_min_size(rail.min, vec2(length, BAR)), 2.0, cause.color);
}

/// One bar of all shares, under its name.
fn whole_bar(ui: &Ui, area: Rect, all: &[Cause], account: &PixelAccount) {
    let tokens = Tokens::in_ui(ui);
    let font = TextStyle::Small.resolve(ui.style());
    let name = ui.painter().text(area.left_top(), Align2::LEFT_TOP, "All pixels", font, tokens.text_weak);
    let mut left = area.left();
    let top = name.bottom() + 4.0;
    for cause in all {
        let width = area.width() * share(cause, account);
        let part = Rect::from_min_size(pos2(left, top), vec2(width, 2.0 * BAR));
        ui.painter().rect_filled(part, 0.0, cause.color);
        left += width;
    }
}
