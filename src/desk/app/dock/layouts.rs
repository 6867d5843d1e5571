//! The first layout of each workspace: shares that suit 1280 × 800, and their limits in larger windows.

use egui::Vec2;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};

use crate::app::model::window::{DockView, Workspace};

/// Width of the side panel: its share of the window's, and at most, in points. Beyond that pictures gain more.
const SIDE_SHARE: f32 = 0.26;
const SIDE_MOST: f32 = 380.0;

/// Height of the lower panel: its share of the views', and at most, in points.
const LOWER_SHARE: f32 = 0.315;
const LOWER_MOST: f32 = 260.0;

const LOWER: [DockView; 4] = [DockView::Pixel, DockView::Cameras, DockView::Time, DockView::Path];

/// The first layout of a workspace.
pub(crate) fn tree_of(workspace: Workspace) -> Tree<DockView> {
    let mut tiles = Tiles::default();
    let root = match workspace {
        Workspace::Explore => {
            let live = tabs(&mut tiles, &[DockView::Live, DockView::Compare]);
            let side = tabs(
                &mut tiles,
                &[DockView::View, DockView::Color, DockView::Path, DockView::Edits, DockView::Thresholds],
            );
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
            // Both have one shape: what is compared at the live viewpoint fills its view.
            let both = beside(&mut tiles, [live, compare], 0.5);
            let side = tabs(&mut tiles, &[DockView::Thresholds, DockView::Report]);
            beside(&mut tiles, [both, side], 1.0 - SIDE_SHARE)
        }
        Workspace::Measure => {
            let charts = tabs(&mut tiles, &[DockView::Tradeoff, DockView::Stability, DockView::Tuning]);
            let live = tabs(&mut tiles, &[DockView::Live, DockView::Compare]);
            let upper = beside(&mut tiles, [charts, live], 0.6);
            let lower = tabs(&mut tiles, &[DockView::Cameras, DockView::Time]);
            with_side(&mut tiles, [upper, lower])
        }
    };
    Tree::new(egui::Id::unique(("views", workspace)), root, tiles)
}

/// Gives the panels of a layout that nobody resized their sizes in an area of `size` points.
pub(crate) fn fit(tree: &mut Tree<DockView>, size: Vec2) {
    let side = SIDE_SHARE.min(SIDE_MOST / size.x);
    let rows = tree.root().and_then(|root| set_share_of_last(tree, root, LinearDir::Horizontal, side));
    if let Some(rows) = rows {
        set_share_of_last(tree, rows, LinearDir::Vertical, LOWER_SHARE.min(LOWER_MOST / size.y));
    }
}

/// Gives the last of the parts that lie along a direction its share; gives the first of them.
fn set_share_of_last(tree: &mut Tree<DockView>, parts: TileId, dir: LinearDir, share: f32) -> Option<TileId> {
    let Some(Tile::Container(Container::Linear(linear))) = tree.tiles.get_mut(parts) else { return None };
    let (last, others) = linear.children.split_last().filter(|(_, others)| !others.is_empty())?;
    if linear.dir != dir {
        return None;
    }
    let rest: f32 = others.iter().map(|other| linear.shares[*other]).sum();
    for other in others {
        linear.shares[*other] *= (1.0 - share) / rest;
    }
    linear.shares.set_share(*last, share);
    others.first().copied()
}

/// Puts a view into a panel of its own, below all but the side panel.
pub(crate) fn put_below(tree: &mut Tree<DockView>, pane: TileId) {
    let Some(root) = tree.root() else { return };
    let lower = tree.tiles.insert_tab_tile(vec![pane]);
    let (mut upper, mut side) = (root, None);
    if let Some(Tile::Container(Container::Linear(linear))) = tree.tiles.get(root)
        && linear.dir == LinearDir::Horizontal
        && let [others @ .., last] = &linear.children[..]
        && !others.is_empty()
    {
        let rest: f32 = others.iter().map(|other| linear.shares[*other]).sum();
        side = Some((*last, rest / (rest + linear.shares[*last])));
        let row = Linear { children: others.to_vec(), ..linear.clone() };
        upper = tree.tiles.insert_container(row);
    }
    let rows = above(&mut tree.tiles, [upper, lower]);
    let with_side = side.map(|(side, share)| beside(&mut tree.tiles, [rows, side], share));
    tree.root = Some(with_side.unwrap_or(rows));
}

/// Two rows of views, and the settings beside both.
fn with_side(tiles: &mut Tiles<DockView>, rows: [TileId; 2]) -> TileId {
    let side = tabs(
        tiles,
        &[DockView::Thresholds, DockView::Report, DockView::View, DockView::Color, DockView::Edits],
    );
    let rows = above(tiles, rows);
    beside(tiles, [rows, side], 1.0 - SIDE_SHARE)
}

/// A view above the lower panel.
fn above(tiles: &mut Tiles<DockView>, pair: [TileId; 2]) -> TileId {
    tiles.insert_container(Linear::new_binary(LinearDir::Vertical, pair, 1.0 - LOWER_SHARE))
}

fn beside(tiles: &mut Tiles<DockView>, pair: [TileId; 2], left_share: f32) -> TileId {
    tiles.insert_container(Linear::new_binary(LinearDir::Horizontal, pair, left_share))
}

/// Views that lie one behind the other, the first in front.
fn tabs(tiles: &mut Tiles<DockView>, views: &[DockView]) -> TileId {
    let panes = views.iter().map(|view| tiles.insert_pane(*view)).collect();
    tiles.insert_tab_tile(panes)
}
