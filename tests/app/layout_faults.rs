//! What is wrong with how a window is laid out: controls over each other, and text that is cut off or lies over other text.

use std::collections::HashMap;

use egui::epaint::TextShape;
use egui::{FullOutput, Rect, Shape, WidgetRect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

/// Points that a text may lie beyond its edge, or over another one: glyphs have some space about them.
const SLACK: f32 = 2.0;

/// A line of text that is drawn, and where it may be seen.
struct DrawnText {
    text: String,
    area: Rect,
    clip: Rect,
}

/// Something to click or drag.
struct Control {
    name: String,
    widget: WidgetRect,
}

/// Every fault, one line each.
pub(crate) fn faults<State>(window: &Harness<'_, State>) -> Vec<String> {
    let controls = controls(window);
    let texts = drawn_texts(window.output());
    let mut faults = controls_over_each_other(&controls);
    faults.extend(texts_cut_off(&texts, &controls));
    faults.extend(texts_over_each_other(&texts));
    faults
}

/// Whether two areas share more than an edge.
fn overlap(a: Rect, b: Rect) -> bool {
    let common = a.intersect(b);
    common.width() > SLACK && common.height() > SLACK
}

/// What of the window can be clicked or dragged, as far as it is seen.
fn controls<State>(window: &Harness<'_, State>) -> Vec<Control> {
    let nodes = window.query_all_by_label_contains("").map(|node| node.accesskit_node());
    // Whatever the tree of names holds beside a name is in the lower half.
    let names = nodes.filter_map(|node| Some(((u128::from(node.id()) >> 64) as u64, node.label()?)));
    let names: HashMap<_, _> = names.collect();
    window.ctx.viewport(|viewport| {
        let widgets = viewport.prev_pass.widgets.layers().flat_map(|(_, layer)| layer);
        let seen = widgets.filter(|widget| widget.visible && widget.interact_rect.is_positive());
        let controls = seen.filter(|widget| widget.sense.interactive()).filter_map(|widget| {
            Some(Control { name: names.get(&widget.id.value())?.clone(), widget: *widget })
        });
        controls.collect()
    })
}

/// What can be clicked or dragged lies beside each other, or one inside the other as buttons lie on a picture.
fn controls_over_each_other(controls: &[Control]) -> Vec<String> {
    let mut faults = Vec::new();
    for (nth, Control { name, widget }) in controls.iter().enumerate() {
        for Control { name: other, widget: beside } in &controls[nth + 1..] {
            let (area, there) = (widget.interact_rect, beside.interact_rect);
            let is_inside = area.contains_rect(there) || there.contains_rect(area);
            let same_layer = widget.layer_id == beside.layer_id;
            if same_layer && overlap(area, there) && (!is_inside || area == there) {
                faults.push(format!("{name:?} at {area} lies over {other:?} at {there}"));
            }
        }
    }
    faults
}

fn drawn_texts(output: &FullOutput) -> Vec<DrawnText> {
    let mut texts = Vec::new();
    for clipped in &output.shapes {
        add_texts(&clipped.shape, clipped.clip_rect, &mut texts);
    }
    texts
}

fn add_texts(shape: &Shape, clip: Rect, texts: &mut Vec<DrawnText>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| add_texts(shape, clip, texts)),
        Shape::Text(drawn) => texts.extend(lines(drawn, clip)),
        _ => {}
    }
}

/// The lines of a text that are seen, at least in part. Icons are drawn as large as their buttons, and are no text.
fn lines(drawn: &TextShape, clip: Rect) -> impl Iterator<Item = DrawnText> {
    drawn.galley.rows.iter().filter_map(move |row| {
        let area = row.rect_without_leading_space().translate(drawn.pos.to_vec2());
        let text = row.text();
        let is_text = text.chars().any(char::is_alphanumeric);
        (is_text && overlap(area, clip)).then_some(DrawnText { text, area, clip })
    })
}

/// Panels scroll up and down; to the side everything is seen but tabs, which are dragged and scrolled, and the table of a pixel.
fn texts_cut_off(texts: &[DrawnText], controls: &[Control]) -> Vec<String> {
    let cut = texts.iter().filter(|drawn| {
        drawn.area.left() < drawn.clip.left() - SLACK || drawn.area.right() > drawn.clip.right() + SLACK
    });
    let is_tab = |drawn: &&DrawnText| {
        controls.iter().any(|control| {
            control.widget.sense.senses_drag()
                && control.name == drawn.text
                && control.widget.rect.contains_rect(drawn.area)
        })
    };
    let rows = controls.iter().filter(|control| control.name.starts_with("Go to the point in "));
    let first = rows.map(|control| control.widget.interact_rect).reduce(Rect::union);
    let table = first.map(|first| Rect::everything_right_of(first.left()).with_min_y(first.top() - 24.0));
    let scrolls = |drawn: &&DrawnText| table.is_some_and(|table| table.contains_rect(drawn.area));
    cut.filter(|drawn| !is_tab(drawn) && !scrolls(drawn))
        .map(|drawn| format!("{:?} at {} is cut off by {}", drawn.text, drawn.area, drawn.clip))
        .collect()
}

fn texts_over_each_other(texts: &[DrawnText]) -> Vec<String> {
    let mut faults = Vec::new();
    for (nth, drawn) in texts.iter().enumerate() {
        for other in &texts[nth + 1..] {
            if overlap(drawn.area.intersect(drawn.clip), other.area.intersect(other.clip)) {
                let (text, at, over, there) = (&drawn.text, drawn.area, &other.text, other.area);
                faults.push(format!("{text:?} at {at} lies over {over:?} at {there}"));
            }
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use egui::{Align2, Button, Color32, FontId, Ui, pos2, vec2};

    use super::*;

    fn found(draw: impl FnMut(&mut Ui)) -> Vec<String> {
        let mut harness = Harness::new_ui(draw);
        harness.run_steps(2);
        faults(&harness)
    }

    fn place(x: f32, width: f32) -> Rect {
        Rect::from_min_size(pos2(x, 20.0), vec2(width, 30.0))
    }

    fn write(ui: &Ui, at: Rect, text: &str) {
        ui.painter_at(at).text(at.min, Align2::LEFT_TOP, text, FontId::proportional(14.0), Color32::WHITE);
    }

    #[test]
    fn controls_and_texts_that_lie_wrong_are_found_and_others_are_not() {
        let beside = found(|ui| {
            ui.put(place(20.0, 80.0), Button::new("Sweep"));
            ui.put(place(110.0, 80.0), Button::new("Sweep"));
            write(ui, place(200.0, 100.0), "Samples");
        });
        assert_eq!(beside, [""; 0]);
        let over = found(|ui| {
            ui.put(place(20.0, 120.0), Button::new("Sweep"));
            ui.put(place(130.0, 120.0), Button::new("Sweep"));
        });
        assert!(over.len() == 1 && over[0].contains("lies over"), "{over:?}");
        let texts = found(|ui| {
            write(ui, place(20.0, 100.0), "Samples");
            write(ui, place(40.0, 100.0), "Memory");
        });
        assert!(texts.len() == 1 && texts[0].contains("lies over"), "{texts:?}");
        let cut = found(|ui| write(ui, place(20.0, 30.0), "Samples kept"));
        assert!(cut.len() == 1 && cut[0].contains("cut off"), "{cut:?}");
    }
}
