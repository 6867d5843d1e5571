//! The shaders of the renderer on graphics cards, as texts in WGSL.
//!
//! Each file beside this one is a stage of the renderer and has one entry point, named like the file; so has each in `seen/` and `sky/`,
//! which find what cameras saw, and in `finish/`, which find holes and fill them. A stage needs some of the shared pieces in
//! `common/` before it; which ones, the engine says (`render/gpu/shaders.rs`).

/// The stage `around`.
pub const AROUND: &str = include_str!("finish/around.wgsl");
/// The stage `average`.
pub const AVERAGE: &str = include_str!("average.wgsl");
/// The stage `blend`.
pub const BLEND: &str = include_str!("blend.wgsl");
/// The stage `carry`.
pub const CARRY: &str = include_str!("seen/carry.wgsl");
/// The stage `display`.
pub const DISPLAY: &str = include_str!("display.wgsl");
/// The stage `enclosed`.
pub const ENCLOSED: &str = include_str!("finish/enclosed.wgsl");
/// The stage `fill`.
pub const FILL: &str = include_str!("finish/fill.wgsl");
/// The stage `fill_sky`.
pub const FILL_SKY: &str = include_str!("sky/fill_sky.wgsl");
/// The stage `free_depths`.
pub const FREE_DEPTHS: &str = include_str!("seen/free_depths.wgsl");
/// The stage `gather`.
pub const GATHER: &str = include_str!("gather.wgsl");
/// The stage `halve_sky`.
pub const HALVE_SKY: &str = include_str!("sky/halve_sky.wgsl");
/// The stage `holes`.
pub const HOLES: &str = include_str!("finish/holes.wgsl");
/// The stage `kinds`.
pub const KINDS: &str = include_str!("finish/kinds.wgsl");
/// The stage `lines_of_sight`.
pub const LINES_OF_SIGHT: &str = include_str!("finish/lines_of_sight.wgsl");
/// The stage `open_holes`.
pub const OPEN_HOLES: &str = include_str!("finish/open_holes.wgsl");
/// The stage `open_sky`.
pub const OPEN_SKY: &str = include_str!("finish/open_sky.wgsl");
/// The stage `pull`.
pub const PULL: &str = include_str!("finish/pull.wgsl");
/// The stage `put_over`.
pub const PUT_OVER: &str = include_str!("finish/put_over.wgsl");
/// The stage `ray_masks`.
pub const RAY_MASKS: &str = include_str!("finish/ray_masks.wgsl");
/// The stage `resolve`.
pub const RESOLVE: &str = include_str!("resolve.wgsl");
/// The stage `rims`.
pub const RIMS: &str = include_str!("finish/rims.wgsl");
/// The stage `silhouette`.
pub const SILHOUETTE: &str = include_str!("silhouette.wgsl");
/// The stage `sky`.
pub const SKY: &str = include_str!("finish/sky.wgsl");
/// The stage `square_ranges`.
pub const SQUARE_RANGES: &str = include_str!("finish/square_ranges.wgsl");
/// The stage `sum_sky`.
pub const SUM_SKY: &str = include_str!("sky/sum_sky.wgsl");
/// The stage `surface`.
pub const SURFACE: &str = include_str!("surface.wgsl");

/// Pieces that several stages share.
pub mod common {
    /// The piece `cell_view`.
    pub const CELL_VIEW: &str = include_str!("common/cell_view.wgsl");
    /// The piece `dense_tile`.
    pub const DENSE_TILE: &str = include_str!("common/dense_tile.wgsl");
    /// The piece `edges`.
    pub const EDGES: &str = include_str!("common/edges.wgsl");
    /// The piece `environment`.
    pub const ENVIRONMENT: &str = include_str!("common/environment.wgsl");
    /// The piece `fillings`.
    pub const FILLINGS: &str = include_str!("common/fillings.wgsl");
    /// The piece `finish`.
    pub const FINISH: &str = include_str!("common/finish.wgsl");
    /// The piece `hole_rays`.
    pub const HOLE_RAYS: &str = include_str!("common/hole_rays.wgsl");
    /// The piece `keys_32`.
    pub const KEYS_32: &str = include_str!("common/keys_32.wgsl");
    /// The piece `keys_64`.
    pub const KEYS_64: &str = include_str!("common/keys_64.wgsl");
    /// The piece `lookup`.
    pub const LOOKUP: &str = include_str!("common/lookup.wgsl");
    /// The piece `patch`.
    pub const PATCH: &str = include_str!("common/patch.wgsl");
    /// The piece `picture`.
    pub const PICTURE: &str = include_str!("common/picture.wgsl");
    /// The piece `project`.
    pub const PROJECT: &str = include_str!("common/project.wgsl");
    /// The piece `pyramid`.
    pub const PYRAMID: &str = include_str!("common/pyramid.wgsl");
    /// The piece `ray_test`.
    pub const RAY_TEST: &str = include_str!("common/ray_test.wgsl");
    /// The piece `reproject`.
    pub const REPROJECT: &str = include_str!("common/reproject.wgsl");
    /// The piece `round`.
    pub const ROUND: &str = include_str!("common/round.wgsl");
    /// The piece `samples`.
    pub const SAMPLES: &str = include_str!("common/samples.wgsl");
    /// The piece `sky_grids`.
    pub const SKY_GRIDS: &str = include_str!("common/sky_grids.wgsl");
    /// The piece `sky_levels`.
    pub const SKY_LEVELS: &str = include_str!("common/sky_levels.wgsl");
    /// The piece `sources`.
    pub const SOURCES: &str = include_str!("common/sources.wgsl");
    /// The piece `stage`.
    pub const STAGE: &str = include_str!("common/stage.wgsl");
    /// The piece `sums`.
    pub const SUMS: &str = include_str!("common/sums.wgsl");
    /// The piece `surroundings`.
    pub const SURROUNDINGS: &str = include_str!("common/surroundings.wgsl");
    /// The piece `tally`.
    pub const TALLY: &str = include_str!("common/tally.wgsl");
}
