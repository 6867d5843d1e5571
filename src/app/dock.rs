//! Views that dock: what there is to look at, where it lies, and what opens beside what.

use egui::{Color32, Frame, Margin, Stroke, Style, Ui, Visuals, WidgetText};
use egui_tiles::{Behavior, Container, Linear, LinearDir, TabState, Tile, TileId, Tiles, Tree, UiResponse};

use super::model::{Command, State};
use super::theme::{Tokens, space};
use super::{views, window};

/// Something to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub(crate) enum DockView {
    /// What a camera saw.
    Source,
    /// What is left, from anywhere.
    Live,
    /// Two pictures of one place.
    Compare,
    /// Why one pixel stays or goes.
    Pixel,
    /// Every camera as a thumbnail.
    Cameras,
    /// Who stands for whom.
    Matrix,
    /// What is stored for how long.
    Time,
    /// What takes the memory.
    Memory,
    /// The thresholds.
    Thresholds,
    /// What was pruned, and why.
    Report,
    /// Accuracy against cost.
    Tradeoff,
    /// Accuracy against disturbances.
    Stability,
    /// The camera path.
    Path,
    /// What happened.
    Log,
}

impl DockView {
    /// Every view, in the order of the menu.
    pub(crate) const ALL: [Self; 14] = [
        Self::Source,
        Self::Live,
        Self::Compare,
        Self::Pixel,
        Self::Cameras,
        Self::Matrix,
        Self::Time,
        Self::Memory,
        Self::Thresholds,
        Self::Report,
        Self::Tradeoff,
        Self::Stability,
        Self::Path,
        Self::Log,
    ];

    /// Its name on its tab.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Source => "Source",
            Self::Live => "Live view",
            Self::Compare => "Compare",
            Self::Pixel => "Pixel",
            Self::Cameras => "Cameras",
            Self::Matrix => "Matrix",
            Self::Time => "Time",
            Self::Memory => "Memory",
            Self::Thresholds => "Thresholds",
            Self::Report => "Report",
            Self::Tradeoff => "Speed and accuracy",
            Self::Stability => "Stability",
            Self::Path => "Camera path",
            Self::Log => "Log",
        }
    }

    /// What it shows, in a sentence.
    pub(crate) fn help(self) -> &'static str {
        match self {
            Self::Source => "What a camera saw, and what became of each of its pixels.",
            Self::Live => "What is left of the capture, from anywhere.",
            Self::Compare => "Two pictures of one place: before and after, two settings, the truth, kernels.",
            Self::Pixel => "The argument for one pixel: what every camera says about it.",
            Self::Cameras => "Every camera with its kept share, and where it sees the pixel.",
            Self::Matrix => "Which camera's samples stand for whose.",
            Self::Time => "For how many frames samples are stored, and when.",
            Self::Memory => "How much memory the samples of each camera take.",
            Self::Thresholds => "What counts as redundant, and how what is left is painted.",
            Self::Report => "What was pruned, by which rule and for which camera.",
            Self::Tradeoff => "What each setting costs, and how close it comes to the truth.",
            Self::Stability => "When accuracy breaks under disturbances.",
            Self::Path => "A camera path: set keys, play it, export it as pictures.",
            Self::Log => "What happened, in order.",
        }
    }

    /// The view beside which it opens.
    fn neighbor(self) -> Self {
        match self {
            Self::Source | Self::Live | Self::Compare | Self::Tradeoff | Self::Stability => Self::Live,
            Self::Thresholds | Self::Report => Self::Thresholds,
            _ => Self::Pixel,
        }
    }
}

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

    /// Draws all views.
    pub(crate) fn ui(&mut self, ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
        let mut desk = Desk { state, commands };
        self.tree.ui(&mut desk, ui);
    }
}

/// What the layout asks of us.
struct Desk<'a> {
    state: &'a State,
    commands: &'a mut Vec<Command>,
}

impl Behavior<DockView> for Desk<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, view: &mut DockView) -> UiResponse {
        let tokens = Tokens::in_ui(ui);
        Frame::new().fill(tokens.surface).inner_margin(Margin::same(space::MEDIUM as i8)).show(ui, |ui| {
            ui.set_min_size(ui.available_size());
            window::view_ui(ui, *view, self.state, self.commands);
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, view: &DockView) -> WidgetText {
        view.name().into()
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<DockView>,
        tile: TileId,
        response: egui::Response,
    ) -> egui::Response {
        match tiles.get_pane(&tile) {
            Some(view) => response.on_hover_text(view.help()),
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
        match tabs.active.and_then(|active| tiles.get_pane(&active)) {
            Some(DockView::Source) => views::cameras_ui(ui, self.state, self.commands),
            Some(DockView::Live) => views::places_ui(ui, self.state, self.commands),
            _ => {}
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
        for view in DockView::ALL.into_iter().chain(DockView::ALL) {
            dock.open(view);
            assert!(dock.holds(view), "{view:?}");
        }
        let panes = dock.tree.tiles.tiles().filter(|tile| matches!(tile, Tile::Pane(_))).count();
        assert_eq!(panes, DockView::ALL.len());
    }
}
