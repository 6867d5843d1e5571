//! Image databases after the Cinema specification D, with columns that say where their cameras stood.
//!
//! Source: *Cinema Specification D*, version 1.2 (Los Alamos National Laboratory): a folder `NAME.cdb` with `data.csv`, whose first row
//! names the columns; those of files come last, and their names begin with `FILE`. What the specification does not say is where a
//! picture was taken from. What differs: further columns say it, in the terms of VTK: `position_x`, `_y`, `_z`, `focal_point_x`…,
//! `up_x`…, and `view_angle`, degrees from the upper edge to the lower one. Without them `phi` and `theta` count: degrees about `up` (+z
//! where there is no such column) and above its plane, at `radius` from the focal point (the origin where there is none).

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};

use super::camera::Camera;
use crate::error::{Error, Result};
use crate::whole_file;

/// Degrees from the upper edge of a picture to the lower one where no column says it: as VTK's cameras have it at first.
const VIEW_ANGLE: f64 = 30.0;

/// Where a camera stands, as a row says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DatabaseCamera {
    /// In the world.
    pub position: DVec3,
    /// The point in the middle of its picture.
    pub focal_point: DVec3,
    /// What points up in its picture; need not be at right angles to the line of sight.
    pub up: DVec3,
    /// From the upper edge to the lower one, degrees.
    pub view_angle: f64,
    /// Half of the world units from the upper edge to the lower one, where lines of sight are parallel.
    pub parallel_scale: Option<f64>,
}

impl DatabaseCamera {
    /// World from camera: x right, y down, z forward; `None` where a number is not finite, or the camera looks nowhere or straight up.
    #[must_use]
    pub fn world_from_camera(&self) -> Option<DAffine3> {
        let forward = (self.focal_point - self.position).try_normalize()?;
        let right = forward.cross(self.up).try_normalize()?;
        let down = forward.cross(right);
        let pose = DAffine3::from_mat3_translation(DMat3::from_cols(right, down, forward), self.position);
        (pose.is_finite() && self.position.is_finite()).then_some(pose)
    }

    /// Pixels of focal length of pictures with so many rows, or per world unit where lines of sight are parallel; `None` where the angle or
    /// the scale is none.
    #[must_use]
    pub fn focal_length_px(&self, rows: f64) -> Option<f64> {
        if let Some(scale) = self.parallel_scale {
            return (scale > 0.0).then(|| 0.5 * rows / scale);
        }
        let is_angle = self.view_angle > 0.0 && self.view_angle < 180.0;
        is_angle.then(|| 0.5 * rows / (0.5 * self.view_angle.to_radians()).tan())
    }
}

/// The direction at `phi` degrees about `up`, counted from the world's x (from its y where x is up), and `theta` degrees above.
#[must_use]
pub fn direction(phi: f64, theta: f64, up: DVec3) -> DVec3 {
    let [along, across] = axes(up);
    let (sin_phi, cos_phi) = phi.to_radians().sin_cos();
    let (sin_theta, cos_theta) = theta.to_radians().sin_cos();
    (along * cos_phi + across * sin_phi) * cos_theta + up.normalize_or_zero() * sin_theta
}

/// Where `phi` is 0, and where it is 90 degrees.
fn axes(up: DVec3) -> [DVec3; 2] {
    let up = up.normalize_or(DVec3::Z);
    let from = if up.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let along = (from - up * from.dot(up)).normalize_or(DVec3::X);
    [along, up.cross(along)]
}

/// Angles, evenly spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleRange {
    /// The first, degrees.
    pub first: f64,
    /// The last, degrees. A whole turn has its first angle once.
    pub last: f64,
    /// How many.
    pub count: usize,
}

impl AngleRange {
    /// All of them, degrees.
    pub fn angles(self) -> impl Iterator<Item = f64> {
        let Self { first, last, count } = self;
        let is_turn = ((last - first).abs() - 360.0).abs() < 1e-9;
        let steps = if is_turn { count } else { count.saturating_sub(1) }.max(1);
        (0..count).map(move |nth| first + (last - first) * nth as f64 / steps as f64)
    }
}

/// The viewpoints at some angles around `pivot`, as far from it as the nearest of the `cameras` and with the lens of the first: each with
/// its `phi` and `theta` in degrees. Without ranges the angles are those between which the cameras stand.
#[must_use]
pub fn grid(
    cameras: &[Camera],
    pivot: DVec3,
    up: DVec3,
    ranges: [Option<AngleRange>; 2],
    counts: [usize; 2],
) -> Vec<([f64; 2], DatabaseCamera)> {
    let aside = cameras.iter().map(|camera| camera.position_in_world() - pivot);
    let radius = aside.clone().map(DVec3::length).fold(f64::INFINITY, f64::min);
    let [along, across] = axes(up);
    let azimuths: Vec<f64> =
        aside.clone().map(|at| at.dot(across).atan2(at.dot(along)).to_degrees()).collect();
    let heights: Vec<f64> = aside
        .map(|at| (at.dot(up) / at.length().max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0).asin().to_degrees())
        .collect();
    let own = [range_of_turn(azimuths), range_of(heights)];
    let [phi, theta] = [0, 1].map(|nth| {
        ranges[nth].unwrap_or(AngleRange { first: own[nth][0], last: own[nth][1], count: counts[nth] })
    });
    let view_angle = cameras.first().map_or(VIEW_ANGLE, |camera| {
        let lens = camera.intrinsics.in_perspective_from(radius);
        2.0 * (0.5 * f64::from(lens.height) / lens.fy).atan().to_degrees()
    });
    let at = |phi: f64, theta: f64| DatabaseCamera {
        position: pivot + direction(phi, theta, up) * radius,
        focal_point: pivot,
        up,
        view_angle,
        parallel_scale: None,
    };
    theta.angles().flat_map(|theta| phi.angles().map(move |phi| ([phi, theta], at(phi, theta)))).collect()
}

/// The least and the largest of some angles.
fn range_of(angles: Vec<f64>) -> [f64; 2] {
    angles
        .into_iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], angle| [least.min(angle), most.max(angle)])
}

/// The shortest way around a circle that passes all of some angles.
fn range_of_turn(mut angles: Vec<f64>) -> [f64; 2] {
    angles.sort_by(f64::total_cmp);
    let Some((first, last)) = angles.first().copied().zip(angles.last().copied()) else { return [0.0, 0.0] };
    let gaps = angles.windows(2).map(|pair| (pair[1] - pair[0], [pair[1], pair[0] + 360.0]));
    let widest = gaps.chain([(first + 360.0 - last, [first, last])]).max_by(|a, b| a.0.total_cmp(&b.0));
    widest.map_or([first, last], |(_, range)| range)
}

/// The table's file.
pub(crate) const DATA: &str = "data.csv";
/// The column of pictures.
pub(crate) const PICTURE_FILE: &str = "FILE";
/// The column of depth: planar, in the unit of positions.
pub(crate) const DEPTH_FILE: &str = "FILE_depth";

/// The columns of a database that is written here. Viewers show the last one of files: pictures, not depth.
const COLUMNS: &str = "time,phi,theta,position_x,position_y,position_z,focal_point_x,focal_point_y,focal_point_z,up_x,up_y,up_z,view_angle,FILE_depth,FILE";

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
        let _ = writeln!(text, "{time},{phi},{theta},{places},{},{depth},{picture}", camera.view_angle);
    }
    whole_file::write_all(&folder.join(DATA), &text)
}

/// A table that was read: the names of its columns, and the fields of its rows.
pub(crate) struct Table {
    path: PathBuf,
    columns: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
    /// The lines whose rows have more or fewer fields than there are columns; they are not among the rows.
    pub(crate) odd_lines: Vec<u64>,
    /// Whether numbers have decimal commas, as spreadsheets of many languages write them between semicolons.
    has_commas: bool,
}

impl Table {
    /// Reads a table.
    ///
    /// # Errors
    /// `Io`, and `Invalid` where it is no table.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let bytes = whole_file::read_all(path)?;
        let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let has_commas = first.contains(&b';') && !first.contains(&b',');
        let mut table = csv::ReaderBuilder::new();
        table.trim(csv::Trim::All).flexible(true).delimiter(if has_commas { b';' } else { b',' });
        let mut reader = table.from_reader(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes));
        let invalid = |error: csv::Error| Error::invalid(path.display(), error.to_string());
        let columns: Vec<String> = reader.headers().map_err(invalid)?.iter().map(str::to_owned).collect();
        let (mut rows, mut odd_lines) = (Vec::new(), Vec::new());
        for row in reader.records() {
            let row = row.map_err(invalid)?;
            if row.len() == columns.len() {
                rows.push(row.iter().map(str::to_owned).collect());
            } else {
                odd_lines.extend(row.position().map(csv::Position::line));
            }
        }
        Ok(Self { path: path.to_path_buf(), columns, rows, odd_lines, has_commas })
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
        let text = self.text(row, name)?;
        let number = if self.has_commas { text.replace(',', ".").parse() } else { text.parse() };
        number.ok().filter(|number: &f64| number.is_finite())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::camera::Intrinsics;

    #[test]
    fn a_direction_turns_about_up_and_rises_above_it() {
        let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-12;
        assert!(near(direction(0.0, 0.0, DVec3::Z), DVec3::X));
        assert!(near(direction(90.0, 0.0, DVec3::Z), DVec3::Y));
        assert!(near(direction(12.0, 90.0, DVec3::Y), DVec3::Y));
        assert!(near(direction(0.0, 0.0, DVec3::X), DVec3::Y));
    }

    #[test]
    fn a_camera_of_a_row_looks_at_its_focal_point_with_its_angle() {
        let camera = DatabaseCamera {
            position: DVec3::new(0.0, -4.0, 0.0),
            focal_point: DVec3::ZERO,
            up: DVec3::new(0.0, 0.3, 1.0),
            view_angle: 90.0,
            parallel_scale: None,
        };
        let pose = camera.world_from_camera().unwrap();
        assert!(
            (pose.matrix3.z_axis - DVec3::Y).length() < 1e-12
                && (pose.matrix3.y_axis + DVec3::Z).length() < 1e-12
        );
        assert!((camera.focal_length_px(480.0).unwrap() - 240.0).abs() < 1e-9);
        assert!(DatabaseCamera { up: DVec3::Y, ..camera }.world_from_camera().is_none(), "it looks along up");
        assert!(DatabaseCamera { view_angle: 0.0, ..camera }.focal_length_px(480.0).is_none());
        let parallel = DatabaseCamera { parallel_scale: Some(3.0), ..camera };
        assert_eq!(parallel.focal_length_px(480.0), Some(80.0), "pixels per world unit");
        assert!(DatabaseCamera { parallel_scale: Some(0.0), ..camera }.focal_length_px(480.0).is_none());
    }

    #[test]
    fn angles_are_spread_evenly_and_a_turn_ends_before_it_begins_again() {
        let all = |first, last, count| AngleRange { first, last, count }.angles().collect::<Vec<_>>();
        assert_eq!(all(-10.0, 10.0, 3), [-10.0, 0.0, 10.0]);
        assert_eq!(all(0.0, 360.0, 4), [0.0, 90.0, 180.0, 270.0]);
        assert_eq!(all(5.0, 9.0, 1), [5.0]);
    }

    #[test]
    fn viewpoints_lie_between_the_cameras_also_where_they_stand_across_half_a_turn() {
        let lens = Intrinsics::from_horizontal_angle(64, 48, 1.0);
        let camera = |phi: f64, theta: f64| {
            Camera::look_at("c", lens, direction(phi, theta, DVec3::Z) * 5.0, DVec3::ZERO, DVec3::Z)
        };
        let cameras = [camera(170.0, 10.0), camera(-160.0, 30.0), camera(180.0, 20.0)];
        let views = grid(&cameras, DVec3::ZERO, DVec3::Z, [None, None], [3, 2]);
        let angles: Vec<[f64; 2]> = views.iter().map(|(angles, _)| angles.map(f64::round)).collect();
        assert_eq!(
            angles,
            [[170.0, 10.0], [185.0, 10.0], [200.0, 10.0], [170.0, 30.0], [185.0, 30.0], [200.0, 30.0]]
        );
        for (_, view) in views {
            assert!((view.position.length() - 5.0).abs() < 1e-9);
            let focal = view.focal_length_px(48.0).unwrap();
            assert!((focal - lens.fy).abs() < 1e-9, "{focal}");
        }
    }
}
