//! Overlook: see, prune and explore animated scenes recorded as color and depth by several static cameras.
//!
//! # The method
//!
//! *Interactive Dynamic Environments Using Image-Based Modeling and Rendering*, one stage a module; each imports only from
//! those before it:
//!
//! | stage | module | what it does |
//! |---|---|---|
//! | collection | [`capture`], [`demo`] | reads what was recorded: cameras, color, depth, normals; or traces a built-in scene |
//! | data model | [`samples`] | samples of all cameras over spans of frames, in tiles |
//! | alignment | [`alignment`] | finds what the rig got wrong (poses, exposure), and mends what pays |
//! | noise | [`preprocess::noise`] | measures how noisy the frames are |
//! | normals | [`preprocess::normals`] | takes given normals or estimates them from depth |
//! | temporal redundancy | [`preprocess::temporal`] | finds the longest spans of frames over which a pixel stays the same |
//! | registration | [`preprocess::registration`] | carries samples into the other cameras: which of them saw the same surface point? |
//! | sampling rate | `preprocess::layers` | of two samples of one point, which is denser? (the paper's `r`) |
//! | spatial redundancy | [`preprocess::pruning`] | keeps the denser one; a sample is dropped only if a kept one represents it |
//! | explanation | [`preprocess::inspect`] | gives for each pixel the rule that kept or dropped it |
//! | placement | [`placement`] | tells from a coarse capture where cameras show the most |
//! | storage | [`store`] | predicts every number from its neighbors and entropy-codes the rest (rANS), in the chunks of an IFF file |
//! | rendering | [`render`] | paints foreground over background into any vantage |
//! | sharing | [`page`], [`splats`] | packs a store into one HTML file that plays in a browser; writes it as Gaussians that viewers of splats open |
//!
//! The crate `overlook-lab` measures how close to the truth that comes and what it costs; `overlook` is the command line and the window
//! over these same calls, and `overlook-python` the module for notebooks.
//!
//! # Frames and units
//!
//! - Camera space: x right, y down, z forward. World space: right-handed, meters unless the capture says otherwise.
//! - Transforms are named `target_from_source`; points and normals carry their space (`point_in_world`).
//! - Pixel `(x, y)` is column x, row y; its center is at `+0.5`. Images are row-major.
//! - Depth is planar z and is carried as **inverse depth** `1/z`: 0 is at infinity (sky), negative is no sample.
//! - Color is linear Rec.709; tolerances and metrics count 8-bit steps of its sRGB encoding ([`color`]).
//!
//! # Words
//!
//! *Sample*: one pixel of one camera over one span of frames. *Span*: a run of frames. *Witness*: the kept sample that represents a
//! dropped one. *Footprint*: the surface area that a pixel covers; the ratio of two footprints is the paper's `r`.
//! *Vantage*: a virtual camera at a frame. `ARCHITECTURE.md` has the whole glossary.
#![warn(clippy::unwrap_used, clippy::expect_used)]

pub mod alignment;
pub mod capture;
pub mod color;
pub mod demo;
pub mod edited_store;
pub mod edits;
pub mod error;
pub mod grid;
pub mod job;
pub mod median;
pub mod page;
pub mod part;
pub mod placement;
pub mod plural;
pub mod preprocess;
pub mod random;
pub mod render;
pub mod samples;
pub mod settings;
pub mod simd;
pub mod splats;
pub mod store;
pub mod stored_verdicts;
pub mod whole_file;
