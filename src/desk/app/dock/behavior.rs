//! How tabs look and what they hold.

use egui::{Color32, Frame, Margin, Rect, Shape, Stroke, Style, Ui, Visuals, WidgetText, pos2};
use egui_material_icons::icons::{ICON_CLOSE_FULLSCREEN, ICON_OPEN_IN_FULL};
use egui_tiles::{Behavior, Container, EditAction, TabState, TileId, Tiles, UiResponse};

use crate::app::rooms::frame::model::{Area, DockView};
use crate::app::theme::{Tokens, space};
use crate::app::widgets;
use crate::app::widgets::icon_button;

/// A part of the layout that a view fills.
#[derive(Clone, Copy)]
pub(crate) enum DockPart {
    /// The view itself.
    Contents,
    /// What is beside the tabs, from right to left, while the view is in front.
    TabBar,
}

/// Draws the contents of a view on its surface, which is left out behind a picture: no graphics card may be there to draw it.
pub(crate) fn contents_ui(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    let surface = Tokens::in_ui(ui).surface;
    let behind = ui.painter().add(Shape::Noop);
    let frame = Frame::new().inner_margin(Margin::same(space::MEDIUM as i8)).show(ui, |ui| {
        ui.set_min_size(ui.available_size());
        contents(ui);
    });
    let area = frame.response.rect;
    let picture = widgets::picture_in(ui, area);
    let around = picture.map_or_else(|| vec![area], |picture| around(area, picture).to_vec());
    let fills = around.into_iter().map(|part| Shape::rect_filled(part, 0.0, surface));
    ui.painter().set(behind, Shape::Vec(fills.collect()));
}

/// An area without what lies in it.
fn around(area: Rect, inside: Rect) -> [Rect; 4] {
    [
        Rect::from_min_max(area.min, pos2(area.right(), inside.top())),
        Rect::from_min_max(pos2(area.left(), inside.bottom()), area.max),
        Rect::from_min_max(pos2(area.left(), inside.top()), inside.left_bottom()),
        Rect::from_min_max(inside.right_top(), pos2(area.right(), inside.bottom())),
    ]
}

/// The button that lets a view fill the window, or puts it back; whether it was clicked.
pub(crate) fn maximize_button(ui: &mut Ui, view: DockView, is_maximized: bool) -> bool {
    let name = view.name_and_help().0;
    let (icon, name) = if is_maximized {
        (ICON_CLOSE_FULLSCREEN, format!("Restore {name}"))
    } else {
        (ICON_OPEN_IN_FULL, format!("Maximize {name}"))
    };
    let help = format!("{name} (Shift+Space, or a double-click on the tab)");
    icon_button(ui, icon, &name, &help).clicked()
}

/// How tabs look and what they hold.
pub(crate) struct DockBehavior<F> {
    pub draw: F,
    /// The view that is to fill the window.
    pub maximized: Option<DockView>,
    /// The view under the pointer.
    pub pointed_at: Option<DockView>,
    /// Whether parts of the layout were resized or moved.
    pub is_arranged: bool,
}

impl<F: FnMut(&mut Ui, DockView, DockPart)> Behavior<DockView> for DockBehavior<F> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, view: &mut DockView) -> UiResponse {
        if ui.rect_contains_pointer(ui.max_rect()) {
            self.pointed_at = Some(*view);
        }
        contents_ui(ui, |ui| (self.draw)(ui, *view, DockPart::Contents));
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, view: &DockView) -> WidgetText {
        view.name_and_help().0.into()
    }

    fn on_edit(&mut self, action: EditAction) {
        self.is_arranged |= matches!(action, EditAction::TileResized | EditAction::TileDropped);
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<DockView>,
        tile: TileId,
        response: egui::Response,
    ) -> egui::Response {
        let Some(view) = tiles.get_pane(&tile) else { return response };
        if response.double_clicked() {
            self.maximized = Some(*view);
        }
        response.on_hover_text(format!("{} Double-click to maximize.", view.name_and_help().1))
    }

    fn top_bar_right_ui(
        &mut self,
        tiles: &Tiles<DockView>,
        ui: &mut Ui,
        _tile: TileId,
        tabs: &egui_tiles::Tabs,
        _scroll: &mut f32,
    ) {
        ui.add_space(space::MEDIUM);
        if let Some(view) = tabs.active.and_then(|active| tiles.get_pane(&active)) {
            if view.area() != Some(Area::Side) && maximize_button(ui, *view, false) {
                self.maximized = Some(*view);
            }
            (self.draw)(ui, *view, DockPart::TabBar);
        }
    }

    fn is_tab_closable(&self, tiles: &Tiles<DockView>, tile: TileId) -> bool {
        // A row of crosses would be louder than the names: the tab in front has one, if it can be missed.
        let in_front = tiles
            .parent_of(tile)
            .and_then(|parent| tiles.get_container(parent))
            .is_some_and(|container| matches!(container, Container::Tabs(tabs) if tabs.is_active(tile)));
        in_front
            && !matches!(
                tiles.get_pane(&tile),
                Some(DockView::Source | DockView::Live | DockView::Thresholds | DockView::Pixel)
            )
    }

    fn tab_bar_height(&self, _style: &Style) -> f32 {
        space::TABS
    }

    fn gap_width(&self, _style: &Style) -> f32 {
        4.0
    }

    fn min_size(&self) -> f32 {
        120.0
    }

    fn simplification_options(&self) -> egui_tiles::SimplificationOptions {
        egui_tiles::SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }

    fn tab_bar_color(&self, visuals: &Visuals) -> Color32 {
        Tokens::of(visuals.dark_mode).background
    }

    fn tab_bg_color(&self, visuals: &Visuals, _: &Tiles<DockView>, _: TileId, tab: &TabState) -> Color32 {
        let tokens = Tokens::of(visuals.dark_mode);
        if tab.active { tokens.surface } else { tokens.background }
    }

    fn tab_outline_stroke(&self, _: &Visuals, _: &Tiles<DockView>, _: TileId, _: &TabState) -> Stroke {
        Stroke::NONE
    }

    fn tab_bar_hline_stroke(&self, visuals: &Visuals) -> Stroke {
        Stroke::new(1.0, Tokens::of(visuals.dark_mode).border)
    }

    fn tab_text_color(&self, visuals: &Visuals, _: &Tiles<DockView>, _: TileId, tab: &TabState) -> Color32 {
        let tokens = Tokens::of(visuals.dark_mode);
        if tab.active { tokens.text } else { tokens.text_weak }
    }
}
