//! Image databases after the Cinema specification D, with columns that say where their cameras stood.
//!
//! Source: *Cinema Specification D*, version 1.2 (Los Alamos National Laboratory): a folder `NAME.cdb` with `data.csv`, whose first row
//! names the columns; those of files come last, and their names begin with `FILE`. What the specification does not say is where a
//! picture was taken from. What differs: further columns say it, in the terms of VTK: `position_x`, `_y`, `_z`, `focal_point_x`…,
//! `up_x`…, and `view_angle`, degrees from the upper edge to the lower one. Without them `phi` and `theta` count: degrees about `up` (+z
//! where there is no such column) and above its plane, at `radius` from the focal point (the origin where there is none).

mod grid;
mod table;
mod viewpoint;

pub use grid::{AngleRange, grid};
pub(crate) use table::{DATA, DEPTH_FILE, PICTURE_FILE, Table};
pub use table::{DatabaseRow, write_table};
pub use viewpoint::{DatabaseCamera, direction};
