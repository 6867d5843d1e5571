//! The layout of the views: where each lies, and what opens beside what.

use egui::{Color32, Frame, Margin, Stroke, Style, Ui, Visuals, WidgetText};
use egui_tiles::{Behavior, Container, Linear, LinearDir, TabState, Tile, TileId, Tiles, Tree, UiResponse};

use super::model::DockView;
use super::theme::{Tokens, space};

/// Where the views lie.
pub(crate) struct Dock {
    tree: Tree<DockView>,
}

/// Shares of the window's width and height at first: what suits 1280 × 800.
const SIDE_SHARE: f32 = 0.26;
const LOWER_SHARE: f32 = 0.315;

impl Dock {
    /// The layout of a first run.
    pub(crate) fn new() -> Self {
        let mut tiles = Tiles::default();
        let tabs = |tiles: &mut Tiles<DockView>, views: &[DockView]| {
            let panes: Vec<TileId> = views.iter().map(|view| tiles.insert_pane(*view)).collect();
            let id = tiles.insert_tab_tile(panes.clone());
            if let (Some(Tile::Container(Container::Tabs(tabs))), Some(first)) =
                (tiles.get_mut(id), panes.first())
            {
                tabs.set_active(*first);
            }
            id
        };
        let source = tabs(&mut tiles, &[DockView::Source]);
        let live = tabs(&mut tiles, &[DockView::Live, DockView::Compare]);
        let lower = tabs(
            &mut tiles,
            &[
                DockView::Pixel,
                DockView::Cameras,
                DockView::Matrix,
                DockView::Time,
                DockView::Memory,
                DockView::Path,
                DockView::Log,
            ],
        );
        let side = tabs(&mut tiles, &[DockView::Thresholds, DockView::Report]);
        let upper = tiles.insert_container(Linear::new(LinearDir::Horizontal, vec![source, live]));
        let left = tiles.insert_container(Linear::new_binary(
            LinearDir::Vertical,
            [upper, lower],
            1.0 - LOWER_SHARE,
        ));
        let root =
            tiles.insert_container(Linear::new_binary(LinearDir::Horizontal, [left, side], 1.0 - SIDE_SHARE));
        Self { tree: Tree::new(egui::Id::unique("views"), root, tiles) }
    }

    /// A layout as [`Dock::to_json`] gave it; that of a first run where it cannot be read or shows nothing.
    pub(crate) fn from_json(text: &str) -> Self {
        match serde_json::from_str::<Tree<DockView>>(text) {
            Ok(tree) if tree.root().is_some() && !tree.tiles.is_empty() => Self { tree },
            _ => Self::new(),
        }
    }

    /// The layout as text.
    pub(crate) fn to_json(&self) -> String {
        serde_json::to_string(&self.tree).unwrap_or_default()
    }

    /// The views that can be seen now.
    pub(crate) fn visible(&self) -> Vec<DockView> {
        self.tree.active_tiles().into_iter().filter_map(|id| self.tree.tiles.get_pane(&id).copied()).collect()
    }

    /// Whether a view is somewhere in the layout.
    pub(crate) fn holds(&self, view: DockView) -> bool {
        self.tree.tiles.find_pane(&view).is_some()
    }

    /// Brings a view to the front, wherever it is; puts it beside its neighbor where it is nowhere.
    pub(crate) fn open(&mut self, view: DockView) {
        if !self.holds(view) {
            let pane = self.tree.tiles.insert_pane(view);
            let beside = self
                .tree
                .tiles
                .find_pane(&view.neighbor())
                .and_then(|neighbor| self.tree.tiles.parent_of(neighbor))
                .or_else(|| self.first_tabs());
            match beside {
                Some(tabs) => self.tree.move_tile_to_container(pane, tabs, usize::MAX, false),
                None => *self = Self::new(),
            }
        }
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(pane) if *pane == view));
    }

    fn first_tabs(&self) -> Option<TileId> {
        let mut tabs: Vec<TileId> = self
            .tree
            .tiles
            .iter()
            .filter(|(_, tile)| matches!(tile, Tile::Container(Container::Tabs(_))))
            .map(|(id, _)| *id)
            .collect();
        tabs.sort_unstable_by_key(|id| id.0);
        tabs.first().copied()
    }

    /// Draws all views: `draw` is given each part of the layout that a view fills.
    pub(crate) fn ui(&mut self, ui: &mut Ui, draw: impl FnMut(&mut Ui, DockView, DockPart)) {
        self.tree.ui(&mut DockBehavior { draw }, ui);
    }
}

/// A part of the layout that a view fills.
#[derive(Clone, Copy)]
pub(crate) enum DockPart {
    /// The view itself.
    Contents,
    /// What is beside the tabs, from right to left, while the view is in front.
    TabBar,
}

/// How tabs look and what they hold.
struct DockBehavior<F> {
    draw: F,
}

impl<F: FnMut(&mut Ui, DockView, DockPart)> Behavior<DockView> for DockBehavior<F> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, view: &mut DockView) -> UiResponse {
        let tokens = Tokens::in_ui(ui);
        Frame::new().fill(tokens.surface).inner_margin(Margin::same(space::MEDIUM as i8)).show(ui, |ui| {
            ui.set_min_size(ui.available_size());
            (self.draw)(ui, *view, DockPart::Contents);
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, view: &DockView) -> WidgetText {
        view.name_and_help().0.into()
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<DockView>,
        tile: TileId,
        response: egui::Response,
    ) -> egui::Response {
        match tiles.get_pane(&tile) {
            Some(view) => response.on_hover_text(view.name_and_help().1),
            None => response,
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_survives_being_saved_and_nonsense_gives_the_first_one() {
        let mut dock = Dock::new();
        dock.open(DockView::Tradeoff);
        let again = Dock::from_json(&dock.to_json());
        assert!(again.holds(DockView::Tradeoff));
        assert!(
            !Dock::from_json("{").holds(DockView::Tradeoff) && Dock::from_json("{").holds(DockView::Live)
        );
    }

    #[test]
    fn every_view_can_be_opened_once() {
        let mut dock = Dock::new();
        for (view, ..) in DockView::ALL.into_iter().chain(DockView::ALL) {
            dock.open(view);
            assert!(dock.holds(view), "{view:?}");
        }
        let panes = dock.tree.tiles.tiles().filter(|tile| matches!(tile, Tile::Pane(_))).count();
        assert_eq!(panes, DockView::ALL.len());
    }
}
