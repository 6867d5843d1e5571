//! Free space: what may be seen behind a nearer surface.
//!
//! A sample behind a nearer surface shows that its own line of sight is free, not that the vantage's is. Where nearer surfaces
//! enclose a pixel, it shows what is behind them only if cameras have seen its whole line of sight free. Else the surfaces
//! around it may go on there, and the pixel is a hole to be filled from them and from the sky: the less of its line of sight was
//! seen free, the more from the surfaces (`sky_share`).
//!
//! ```text
//!     N N N N     N: nearer surface     .: the sky, or something at least twice as far
//!     N . . N     The dots are enclosed: in seven of eight directions a nearer surface is found within 16 pixels, or the edge of
//!     N N . N     the picture, with nothing between whose line of sight is free.
//! ```
//!
//! Sources: Curless and Levoy, *A Volumetric Method for Building Complex Models from Range Images*, SIGGRAPH 1996 (empty, unseen,
//! near the surface); Kutulakos and Seitz, *A Theory of Shape by Space Carving*, IJCV 2000. What differs: no volume is built; lines
//! of sight are tested where the question arises, against what each camera saw. That a pixel must be enclosed was measured: of
//! lines of sight through unseen space, nearly all that surfaces enclose ended on a surface, and nearly all others at the sky.
//! Where no camera saw anything at infinity, no line of sight is tested.

mod hidden;
mod ray_test;
mod seen_depth;
mod surroundings;

pub(crate) use hidden::{HOLE, MarkPlanes, OPEN_HOLE, SKY_HOLE, hidden_surface_limit, mark_holes};
pub(crate) use ray_test::{RayTest, behind_ratio, cameras_to_ask};
pub(crate) use seen_depth::{BORDER as CELL_BORDER, SeenDepths};
pub(crate) use surroundings::{HolePlace, sky_share};
