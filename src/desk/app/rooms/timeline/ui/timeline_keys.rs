//! The keys of the camera path on the time bar, which are dragged to another frame.

use egui::{CursorIcon, Id, Painter, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::path::model::PathCommand;
use crate::app::theme::Tokens;

/// Half the width of a key, and how far around its middle it is taken hold of, points.
const HALF: f32 = 5.5;
const REACH: f32 = 8.0;

/// Draws the keys into the bar, over what it shows, and lets them be dragged. The columns of frames are `step` wide.
pub(crate) fn keys_ui(
    ui: &mut Ui,
    painter: &Painter,
    (bar, step): (Rect, f32),
    state: &State,
    commands: &mut Commands,
) {
    let tokens = Tokens::in_ui(ui);
    let last = state.frame_count().saturating_sub(1);
    let keys = &state.doc.path.keys;
    for (index, key) in keys.iter().enumerate() {
        // Of keys at one frame the last lies above and is taken first.
        if keys[index + 1..].iter().any(|later| later.frame.min(last) == key.frame.min(last)) {
            continue;
        }
        let x = bar.left() + (key.frame.min(last) as f32 + 0.5) * step;
        let middle = pos2(x, bar.bottom() - HALF - 1.0);
        let area = Rect::from_center_size(middle, vec2(2.0 * REACH, 2.0 * REACH)).intersect(bar);
        let response = ui.interact(area, Id::unique(("key of the path", index)), Sense::click_and_drag());
        let name = format!("Key {} on the time bar", index + 1);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        let is_held = response.dragged() || response.hovered();
        let color = if is_held { tokens.accent } else { tokens.warning };
        painter.add(Shape::convex_polygon(diamond(middle), color, Stroke::new(1.0, tokens.background)));
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let frame = ((pointer.x - bar.left()) / step).clamp(0.0, last as f32) as usize;
            if frame != key.frame {
                let key = Some(index);
                commands.push(Command::Path(PathCommand::change(&state.doc.path, key, |path| {
                    path.move_key(index, frame)
                })));
            }
        }
        if response.clicked() {
            commands.push(Command::Path(PathCommand::GoToKey(index)));
        }
        let help = format!(
            "Key {} at frame {}. Drag it to another frame; a click goes there.",
            index + 1,
            key.frame + 1
        );
        response.on_hover_cursor(CursorIcon::ResizeHorizontal).on_hover_text(help);
    }
}

fn diamond(middle: egui::Pos2) -> Vec<egui::Pos2> {
    [(0.0, -HALF), (HALF, 0.0), (0.0, HALF), (-HALF, 0.0)].map(|(x, y)| middle + vec2(x, y)).to_vec()
}
