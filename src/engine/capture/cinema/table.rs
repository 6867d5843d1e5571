//! The table of a database: reading `data.csv`, and writing it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::viewpoint::{DatabaseCamera, VIEW_ANGLE, direction};
use crate::error::{Error, Result};
use crate::whole_file;

/// The table's file.
pub(crate) const DATA: &str = "data.csv";
/// The column of pictures.
pub(crate) const PICTURE_FILE: &str = "FILE";
/// The column of depth: planar, in the unit of positions.
pub(crate) const DEPTH_FILE: &str = "FILE_depth";

/// The columns of a database that is written here.
const COLUMNS: &str = "time,phi,theta,position_x,position_y,position_z,focal_point_x,focal_point_y,focal_point_z,up_x,up_y,up_z,view_angle,FILE,FILE_depth";

/// A picture of a database that is written.
#[derive(Clone, Debug, PartialEq)]
pub struct DatabaseRow {
    /// The frame's number.
    pub time: i64,
    /// About up and above its plane, degrees.
    pub angles: [f64; 2],
    /// Where from.
    pub camera: DatabaseCamera,
    /// Names of the picture and of the file of its depth, in the folder.
    pub files: [String; 2],
}

/// Writes the table of a database into its folder. Numbers are written so that the same are read again.
///
/// # Errors
/// `Io`.
pub fn write_table(folder: &Path, rows: &[DatabaseRow]) -> Result<()> {
    let mut text = format!("{COLUMNS}\n");
    for DatabaseRow { time, angles: [phi, theta], camera, files: [picture, depth] } in rows {
        let points = [camera.position, camera.focal_point, camera.up];
        let places = points.map(|point| format!("{},{},{}", point.x, point.y, point.z)).join(",");
        // A string takes all that is written.
        let _ = writeln!(text, "{time},{phi},{theta},{places},{},{picture},{depth}", camera.view_angle);
    }
    whole_file::write_all(&folder.join(DATA), &text)
}

/// A table that was read: the names of its columns, and the fields of its rows.
pub(crate) struct Table {
    path: PathBuf,
    columns: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a table.
    ///
    /// # Errors
    /// `Io`, and `Invalid` where a row has more or fewer fields than there are columns.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let bytes = whole_file::read_all(path)?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
        let invalid = |error: csv::Error| Error::invalid(path.display(), error.to_string());
        let columns = reader.headers().map_err(invalid)?.iter().map(str::to_owned).collect();
        let rows = reader.records().map(|row| Ok(row.map_err(invalid)?.iter().map(str::to_owned).collect()));
        Ok(Self { path: path.to_path_buf(), columns, rows: rows.collect::<Result<_>>()? })
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.eq_ignore_ascii_case(name))
    }

    /// Whether there is a column.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    /// What stands in a column; `None` where there is no such column, or nothing in it.
    pub(crate) fn text<'a>(&self, row: &'a [String], name: &str) -> Option<&'a str> {
        self.column(name)
            .and_then(|column| row.get(column))
            .map(String::as_str)
            .filter(|text| !text.is_empty())
    }

    /// The number in a column; `None` where none stands there.
    pub(crate) fn number(&self, row: &[String], name: &str) -> Option<f64> {
        self.text(row, name)?.parse().ok().filter(|number: &f64| number.is_finite())
    }

    fn point(&self, row: &[String], name: &str) -> Option<DVec3> {
        let [x, y, z] = ["x", "y", "z"].map(|axis| self.number(row, &format!("{name}_{axis}")));
        Some(DVec3::new(x?, y?, z?))
    }

    /// Where the cameras of all rows stand; one of a row is `None` where a number of its own is missing.
    ///
    /// # Errors
    /// `Invalid` where the columns do not say it, with those that would.
    pub(crate) fn cameras(&self) -> Result<Vec<Option<DatabaseCamera>>> {
        let has_positions = self.has("position_x");
        let has_angles = self.has("phi") && self.has("theta");
        if !(has_positions || has_angles && self.has("radius")) {
            let angles =
                if has_angles { "phi and theta stand in it, but not how far from what: " } else { "" };
            let what = format!(
                "{angles}where its pictures were taken from is not known; give columns radius and view_angle (degrees) beside phi and theta, or position_x, _y, _z and focal_point_x, _y, _z"
            );
            return Err(Error::invalid(self.path.display(), what));
        }
        Ok(self.rows.iter().map(|row| self.camera(row, has_positions)).collect())
    }

    fn camera(&self, row: &[String], has_positions: bool) -> Option<DatabaseCamera> {
        let up = self.point(row, "up").unwrap_or(DVec3::Z);
        let focal_point = self.point(row, "focal_point").unwrap_or_default();
        let position = if has_positions {
            self.point(row, "position")?
        } else {
            let [phi, theta, radius] = ["phi", "theta", "radius"].map(|name| self.number(row, name));
            focal_point + direction(phi?, theta?, up) * radius?
        };
        let view_angle = self.number(row, "view_angle").unwrap_or(VIEW_ANGLE);
        // As VTK's cameras have it.
        let is_parallel = self.number(row, "parallel_projection").is_some_and(|is_so| is_so != 0.0);
        let parallel_scale = is_parallel.then(|| self.number(row, "parallel_scale").unwrap_or(0.0));
        Some(DatabaseCamera { position, focal_point, up, view_angle, parallel_scale })
    }
}
