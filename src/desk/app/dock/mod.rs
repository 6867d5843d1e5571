//! The layout of the views: the place of each in every workspace, and beside which view another opens.

mod layouts;

use std::collections::{BTreeMap, BTreeSet};

use egui::{
    Align, Color32, Frame, Layout, Margin, Rect, Shape, Stroke, Style, Ui, Visuals, WidgetText, pos2,
};
use egui_material_icons::icons::{ICON_CLOSE_FULLSCREEN, ICON_OPEN_IN_FULL};
use egui_tiles::{Behavior, Container, EditAction, TabState, Tile, TileId, Tiles, Tree, UiResponse};

use crate::app::model::window::{Area, DockView, Workspace};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{self, icon_button};

/// The layout of the views of each workspace.
#[derive(serde::Serialize)]
pub(crate) struct Dock {
    workspace: Workspace,
    /// One for every workspace.
    layouts: BTreeMap<Workspace, Tree<DockView>>,
    /// Workspaces whose layouts nobody arranged: they fit windows of any size.
    fitted: BTreeSet<Workspace>,
    /// The view that the pointer was over when it was last drawn.
    #[serde(skip)]
    pointed_at: Option<DockView>,
}

/// Layouts as they are read: one by one, so that what cannot be read costs one layout and not all.
#[derive(serde::Deserialize)]
struct RememberedLayouts {
    workspace: Workspace,
    layouts: BTreeMap<Workspace, serde_json::Value>,
    fitted: BTreeSet<Workspace>,
}

impl Dock {
    /// The layouts of a first run.
    pub(crate) fn new() -> Self {
        let all = Workspace::ALL.map(|(workspace, ..)| workspace);
        let layouts = all.map(|workspace| (workspace, layouts::tree_of(workspace))).into();
        Self { workspace: Workspace::default(), layouts, fitted: all.into(), pointed_at: None }
    }

    /// Layouts as [`Dock::to_json`] gave them; that of a first run for each that cannot be read or shows nothing.
    pub(crate) fn from_json(text: &str) -> Self {
        let mut dock = Self::new();
        let readable = |mut layout: serde_json::Value| {
            leave_out_unknown(&mut layout);
            let tree = serde_json::from_value::<Tree<DockView>>(layout).ok()?;
            (tree.root().is_some() && !tree.tiles.is_empty()).then_some(tree)
        };
        if let Ok(remembered) = serde_json::from_str::<RememberedLayouts>(text) {
            dock.workspace = remembered.workspace;
            for (workspace, layout) in remembered.layouts {
                if let Some(tree) = readable(layout) {
                    dock.layouts.insert(workspace, tree);
                    dock.fitted.retain(|of| *of != workspace || remembered.fitted.contains(of));
                }
            }
        }
        dock
    }

    /// The layouts as text.
    pub(crate) fn to_json(&self) -> String {
        // As a value first: its keys are in order, so that layouts that are alike give one text.
        serde_json::to_value(self).unwrap_or_default().to_string()
    }

    /// The workspace that is shown.
    pub(crate) fn workspace(&self) -> Workspace {
        self.workspace
    }

    /// Shows another workspace.
    pub(crate) fn show_workspace(&mut self, workspace: Workspace) {
        self.workspace = workspace;
    }

    /// Restores the first layout of the shown workspace.
    pub(crate) fn reset(&mut self) {
        self.layouts.insert(self.workspace, layouts::tree_of(self.workspace));
        self.fitted.insert(self.workspace);
    }

    fn tree(&self) -> &Tree<DockView> {
        &self.layouts[&self.workspace]
    }

    fn tree_mut(&mut self) -> &mut Tree<DockView> {
        let workspace = self.workspace;
        self.layouts.entry(workspace).or_insert_with(|| layouts::tree_of(workspace))
    }

    /// The views that can be seen now.
    pub(crate) fn visible(&self) -> Vec<DockView> {
        let tree = self.tree();
        tree.active_tiles().iter().filter_map(|id| tree.tiles.get_pane(id).copied()).collect()
    }

    /// Whether a view is somewhere in the layout.
    pub(crate) fn holds(&self, view: DockView) -> bool {
        self.tree().tiles.find_pane(&view).is_some()
    }

    /// The view that the pointer is over.
    pub(crate) fn pointed_at(&self) -> Option<DockView> {
        self.pointed_at
    }

    /// The area that a view is hidden and shown with where it lies now; `None` for those in the middle.
    pub(crate) fn area_of(&self, view: DockView) -> Option<Area> {
        let tree = self.tree();
        tree.tiles.find_pane(&view).map_or(view.area(), |pane| area_at(tree, pane))
    }

    /// Shows or hides the views of an area, at any place.
    pub(crate) fn show_area(&mut self, area: Area, show: bool) {
        let tree = self.tree_mut();
        let panes: Vec<TileId> =
            tree.tiles.tile_ids().filter(|tile| area_at(tree, *tile) == Some(area)).collect();
        for pane in panes {
            tree.tiles.set_visible(pane, show);
        }
    }

    /// Shows or hides one view, at any place.
    pub(crate) fn show_view(&mut self, view: DockView, show: bool) {
        let tree = self.tree_mut();
        if let Some(pane) = tree.tiles.find_pane(&view) {
            tree.tiles.set_visible(pane, show);
        }
    }

    /// Brings a view to the front; one that is not in the layout is put beside its neighbor.
    pub(crate) fn open(&mut self, view: DockView) {
        let (is_new, workspace) = (!self.holds(view), self.workspace);
        let tree = self.tree_mut();
        if is_new {
            let pane = tree.tiles.insert_pane(view);
            let beside = (tree.tiles.find_pane(&view.neighbor()))
                .and_then(|neighbor| tree.tiles.parent_of(neighbor))
                .or_else(|| first_tabs(tree, |area| area.is_some() && area == view.area()));
            let anywhere = || first_tabs(tree, |_| view.area() != Some(Area::Lower));
            match beside.or_else(anywhere) {
                Some(tabs) => tree.move_tile_to_container(pane, tabs, usize::MAX, false),
                None if tree.root().is_some() => layouts::put_below(tree, pane),
                None => *tree = layouts::tree_of(workspace),
            }
        }
        let tree = self.tree_mut();
        tree.make_active(|_, tile| matches!(tile, Tile::Pane(pane) if *pane == view));
    }

    /// Draws all views, or the one that is `maximized`, by `draw` for each part of the layout. Returns the view that a person
    /// maximizes or restores, if any.
    pub(crate) fn ui(
        &mut self,
        ui: &mut Ui,
        maximized: Option<DockView>,
        mut draw: impl FnMut(&mut Ui, DockView, DockPart),
    ) -> Option<DockView> {
        if let Some(view) = maximized {
            self.pointed_at = Some(view);
            return maximized_ui(ui, view, draw).then_some(view);
        }
        if self.fitted.contains(&self.workspace) {
            layouts::fit(self.tree_mut(), ui.available_size());
        }
        let mut behavior =
            DockBehavior { draw: &mut draw, maximized: None, pointed_at: None, is_arranged: false };
        self.tree_mut().ui(&mut behavior, ui);
        let DockBehavior { maximized, pointed_at, is_arranged, .. } = behavior;
        self.pointed_at = pointed_at;
        if is_arranged {
            self.fitted.remove(&self.workspace);
        }
        maximized
    }
}

/// Leaves views out of a remembered layout that no longer exist: what held them closes the gap when it is drawn.
fn leave_out_unknown(layout: &mut serde_json::Value) {
    let is_known = |tile: &serde_json::Value| {
        tile.get("Pane").is_none_or(|pane| serde_json::from_value::<DockView>(pane.clone()).is_ok())
    };
    if let Some(tiles) = layout.pointer_mut("/tiles/tiles").and_then(|tiles| tiles.as_object_mut()) {
        tiles.retain(|_, tile| is_known(tile));
    }
}

/// The tabs that were there first, of those that begin with a view of a wanted area.
fn first_tabs(tree: &Tree<DockView>, is_wanted: impl Fn(Option<Area>) -> bool) -> Option<TileId> {
    let tabs = tree.tiles.iter().filter(|(_, tile)| matches!(tile, Tile::Container(Container::Tabs(_))));
    tabs.map(|(id, _)| *id).filter(|id| is_wanted(area_of_tabs(tree, *id))).min_by_key(|id| id.0)
}

/// The area of the view that tabs begin with.
fn area_of_tabs(tree: &Tree<DockView>, tile: TileId) -> Option<Area> {
    let Some(Tile::Container(Container::Tabs(tabs))) = tree.tiles.get(tile) else { return None };
    tree.tiles.get_pane(tabs.children.first()?)?.area()
}

/// The area of a pane: a pane in a panel has the area of the panel, which is hidden as a whole.
fn area_at(tree: &Tree<DockView>, pane: TileId) -> Option<Area> {
    let own = tree.tiles.get_pane(&pane)?.area()?;
    let panel = tree.tiles.parent_of(pane).and_then(|tabs| area_of_tabs(tree, tabs));
    let is_panel = |area: Area| area != Area::Source;
    Some(panel.filter(|panel| is_panel(*panel) && is_panel(own)).unwrap_or(own))
}

/// Draws one view below its name; whether it is to be put back.
fn maximized_ui(ui: &mut Ui, view: DockView, mut draw: impl FnMut(&mut Ui, DockView, DockPart)) -> bool {
    let mut restores = false;
    let width = ui.available_width();
    ui.spacing_mut().item_spacing.y = 0.0;
    ui.allocate_ui_with_layout(egui::vec2(width, space::TABS), Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(width);
        ui.add_space(space::MEDIUM);
        let tokens = Tokens::in_ui(ui);
        let name = egui::RichText::new(view.name_and_help().0).color(tokens.text);
        let name = ui.add(egui::Button::new(name).frame(false));
        restores |= name.on_hover_text("Double-click to restore.").double_clicked();
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(space::MEDIUM);
            restores |= maximize_button(ui, view, true);
            draw(ui, view, DockPart::TabBar);
        });
    });
    contents_ui(ui, |ui| draw(ui, view, DockPart::Contents));
    restores
}

/// A part of the layout that a view fills.
#[derive(Clone, Copy)]
pub(crate) enum DockPart {
    /// The view itself.
    Contents,
    /// What is beside the tabs, from right to left, while the view is in front.
    TabBar,
}

/// Draws the contents of a view on its surface, which is left out behind a picture: no graphics card may be there to draw it.
fn contents_ui(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    let surface = Tokens::in_ui(ui).surface;
    let behind = ui.painter().add(Shape::Noop);
    let frame = Frame::new().inner_margin(Margin::same(space::MEDIUM as i8)).show(ui, |ui| {
        ui.set_min_size(ui.available_size());
        contents(ui);
    });
    let area = frame.response.rect;
    let picture = widgets::drawn_picture(ui.ctx(), |_, picture| area.contains_rect(picture));
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
fn maximize_button(ui: &mut Ui, view: DockView, is_maximized: bool) -> bool {
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
struct DockBehavior<F> {
    draw: F,
    /// The view that is to fill the window.
    maximized: Option<DockView>,
    /// The view under the pointer.
    pointed_at: Option<DockView>,
    /// Whether parts of the layout were resized or moved.
    is_arranged: bool,
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
        if let Some(DockView::Source | DockView::Live | DockView::Thresholds | DockView::Pixel) =
            tiles.get_pane(&tile)
        {
            return false;
        }
        // A row of crosses would be louder than the names: the tab in front has one, if it can be missed.
        let container = tiles.parent_of(tile).and_then(|parent| tiles.get_container(parent));
        matches!(container, Some(Container::Tabs(tabs)) if tabs.is_active(tile))
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
    use egui::Vec2;

    #[test]
    fn each_workspace_keeps_its_layout_and_nonsense_gives_the_first_one() {
        let mut dock = Dock::new();
        for (workspace, ..) in Workspace::ALL {
            dock.show_workspace(workspace);
            assert!(dock.visible().contains(&DockView::Live), "{workspace:?}");
        }
        dock.show_workspace(Workspace::Compare);
        dock.open(DockView::Path);
        let mut again = Dock::from_json(&dock.to_json());
        assert_eq!(again.workspace(), Workspace::Compare);
        assert!(again.holds(DockView::Path));
        again.show_workspace(Workspace::Measure);
        assert!(!again.holds(DockView::Path));
        assert_eq!(Dock::from_json("{").visible(), Dock::new().visible());
    }

    #[test]
    fn a_layout_with_a_view_that_no_longer_exists_keeps_the_others_where_they_were() {
        let mut dock = Dock::new();
        for view in [DockView::Stability, DockView::Live] {
            dock.open(view);
        }
        dock.show_area(Area::Source, false);
        let text = dock.to_json().replace("\"Stability\"", "\"Memory\"").replace("\"Time\"", "\"Log\"");
        let again = Dock::from_json(&text);
        assert!(again.holds(DockView::Path) && again.visible().contains(&DockView::Live));
        assert!(!again.holds(DockView::Stability) && !again.holds(DockView::Time));
        assert!(!again.visible().contains(&DockView::Source), "it is hidden, as before");
    }

    #[test]
    fn an_area_is_hidden_and_shown_again_where_it_was() {
        let mut dock = Dock::new();
        let before = dock.visible();
        for (area, ..) in Area::ALL {
            dock.show_area(area, false);
            assert!(dock.visible().iter().all(|view| view.area() != Some(area)), "{area:?}");
            assert!(dock.visible().contains(&DockView::Live));
            dock.show_area(area, true);
            assert_eq!(dock.visible(), before);
        }
    }

    #[test]
    fn a_panel_is_hidden_with_every_view_in_it() {
        let mut dock = Dock::new();
        dock.show_workspace(Workspace::Explore);
        assert_eq!(dock.area_of(DockView::Path), Some(Area::Side), "it lies in the side panel here");
        dock.open(DockView::Path);
        let before = dock.visible();
        dock.show_area(Area::Lower, false);
        assert_eq!(dock.visible(), before);
        dock.show_area(Area::Side, false);
        assert_eq!(dock.visible(), [DockView::Live]);
        dock.show_area(Area::Side, true);
        assert_eq!(dock.visible(), before);
        dock.show_workspace(Workspace::Inspect);
        assert_eq!(dock.area_of(DockView::Path), Some(Area::Lower));
    }

    #[test]
    fn a_view_of_the_lower_panel_opens_below_the_others_where_there_is_no_such_panel() {
        for (workspace, ..) in Workspace::ALL {
            let mut dock = Dock::new();
            dock.show_workspace(workspace);
            let before = dock.visible();
            let has_panel = before.iter().any(|view| view.area() == Some(Area::Lower));
            for view in [DockView::Pixel, DockView::Time] {
                dock.open(view);
                let seen = dock.visible();
                assert!(seen.contains(&view), "{workspace:?}");
                assert_eq!(seen.len(), before.len() + usize::from(!has_panel), "{workspace:?}: {seen:?}");
                let above = before.iter().filter(|view| view.area() != Some(Area::Lower));
                assert!(above.into_iter().all(|view| seen.contains(view)), "{workspace:?}: {seen:?}");
            }
        }
    }

    #[test]
    fn a_large_window_gives_its_space_to_pictures_until_panels_are_resized() {
        let shares = |dock: &mut Dock, size: Vec2| {
            layouts::fit(dock.tree_mut(), size);
            let tree = dock.tree_mut();
            let Some(Tile::Container(Container::Linear(root))) = tree.tiles.get(tree.root().unwrap()) else {
                panic!("views beside a side panel");
            };
            let sides = root.children.iter().map(|child| root.shares[*child]);
            sides.collect::<Vec<f32>>()
        };
        for (workspace, ..) in Workspace::ALL {
            let mut dock = Dock::new();
            dock.show_workspace(workspace);
            let small = shares(&mut dock, egui::vec2(1280.0, 600.0))[1];
            let large = shares(&mut dock, egui::vec2(2560.0, 1240.0))[1];
            assert!((small - 0.26).abs() < 1e-6 && (large * 2560.0 - 380.0).abs() < 0.1, "{workspace:?}");
        }
        let mut dock = Dock::new();
        dock.fitted.remove(&Workspace::Inspect);
        let again = Dock::from_json(&dock.to_json());
        assert!(!again.fitted.contains(&Workspace::Inspect));
        assert!(Dock::from_json(&Dock::new().to_json()).fitted.contains(&Workspace::Inspect));
    }

    #[test]
    fn every_view_can_be_opened_once() {
        let mut dock = Dock::new();
        for (view, ..) in DockView::ALL.into_iter().chain(DockView::ALL) {
            dock.open(view);
            assert!(dock.holds(view), "{view:?}");
        }
        let panes = dock.tree_mut().tiles.tiles().filter(|tile| matches!(tile, Tile::Pane(_))).count();
        assert_eq!(panes, DockView::ALL.len());
    }
}
