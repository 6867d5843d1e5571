//! The shaders of the renderer on graphics cards, as texts in WGSL.
//!
//! Each file beside this one is a stage of the renderer and has one entry point, named like the file. A stage needs some of the
//! shared pieces in `common/` before it; which ones, the engine says (`render/gpu/shaders.rs`).

/// The stage `blend`.
pub const BLEND: &str = include_str!("blend.wgsl");
/// The stage `display`.
pub const DISPLAY: &str = include_str!("display.wgsl");
/// The stage `gather`.
pub const GATHER: &str = include_str!("gather.wgsl");
/// The stage `resolve`.
pub const RESOLVE: &str = include_str!("resolve.wgsl");
/// The stage `silhouette`.
pub const SILHOUETTE: &str = include_str!("silhouette.wgsl");
/// The stage `surface`.
pub const SURFACE: &str = include_str!("surface.wgsl");

/// Pieces that several stages share.
pub mod common {
    /// The piece `dense_tile`.
    pub const DENSE_TILE: &str = include_str!("common/dense_tile.wgsl");
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
    /// The piece `reproject`.
    pub const REPROJECT: &str = include_str!("common/reproject.wgsl");
    /// The piece `samples`.
    pub const SAMPLES: &str = include_str!("common/samples.wgsl");
    /// The piece `stage`.
    pub const STAGE: &str = include_str!("common/stage.wgsl");
    /// The piece `sums`.
    pub const SUMS: &str = include_str!("common/sums.wgsl");
}
