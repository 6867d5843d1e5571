//! Where the views of each workspace lie at first: shares that suit 1280 × 800.

use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};

use crate::app::model::{DockView, Workspace};

/// Width of the side panel, as a share of the window's.
const SIDE_SHARE: f32 = 0.26;

/// Height of the lower panel, as a share of the views'.
const LOWER_SHARE: f32 = 0.315;

const LOWER: [DockView; 7] = [
    DockView::Pixel,
    DockView::Cameras,
    DockView::Matrix,
    DockView::Time,
    DockView::Memory,
    DockView::Path,
    DockView::Log,
];

/// The first layout of a workspace.
pub(super) fn tree_of(workspace: Workspace) -> Tree<DockView> {
    let mut tiles = Tiles::default();
    let root = match workspace {
        Workspace::Explore => {
            let live = tabs(&mut tiles, &[DockView::Live, DockView::Compare]);
            let side =
                tabs(&mut tiles, &[DockView::View, DockView::Color, DockView::Path, DockView::Thresholds]);
            beside(&mut tiles, [live, side], 1.0 - SIDE_SHARE)
        }
        Workspace::Inspect => {
            let source = tabs(&mut tiles, &[DockView::Source]);
            let live = tabs(&mut tiles, &[DockView::Live, DockView::Compare]);
            let upper = beside(&mut tiles, [source, live], 0.5);
            let lower = tabs(&mut tiles, &LOWER);
            with_side(&mut tiles, [upper, lower])
        }
        Workspace::Compare => {
            let live = tabs(&mut tiles, &[DockView::Live, DockView::Source]);
            let compare = tabs(&mut tiles, &[DockView::Compare]);
            let both = beside(&mut tiles, [live, compare], 0.4);
            let side = tabs(&mut tiles, &[DockView::Thresholds, DockView::Report]);
            beside(&mut tiles, [both, side], 1.0 - SIDE_SHARE)
        }
        Workspace::Measure => {
            let charts = tabs(&mut tiles, &[DockView::Tradeoff, DockView::Stability]);
            let live = tabs(&mut tiles, &[DockView::Live, DockView::Compare]);
            let upper = beside(&mut tiles, [charts, live], 0.6);
            let lower = tabs(
                &mut tiles,
                &[DockView::Memory, DockView::Time, DockView::Matrix, DockView::Cameras, DockView::Log],
            );
            with_side(&mut tiles, [upper, lower])
        }
    };
    Tree::new(egui::Id::unique(("views", workspace)), root, tiles)
}

/// Two rows of views, and the settings beside both.
fn with_side(tiles: &mut Tiles<DockView>, rows: [TileId; 2]) -> TileId {
    let side = tabs(tiles, &[DockView::Thresholds, DockView::Report, DockView::View, DockView::Color]);
    let rows = tiles.insert_container(Linear::new_binary(LinearDir::Vertical, rows, 1.0 - LOWER_SHARE));
    beside(tiles, [rows, side], 1.0 - SIDE_SHARE)
}

fn beside(tiles: &mut Tiles<DockView>, pair: [TileId; 2], left_share: f32) -> TileId {
    tiles.insert_container(Linear::new_binary(LinearDir::Horizontal, pair, left_share))
}

/// Views that lie one behind the other, the first in front.
fn tabs(tiles: &mut Tiles<DockView>, views: &[DockView]) -> TileId {
    let panes: Vec<TileId> = views.iter().map(|view| tiles.insert_pane(*view)).collect();
    let id = tiles.insert_tab_tile(panes.clone());
    if let (Some(Tile::Container(Container::Tabs(tabs))), Some(first)) = (tiles.get_mut(id), panes.first()) {
        tabs.set_active(*first);
    }
    id
}
