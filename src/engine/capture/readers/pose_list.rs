//! A folder of color, a folder of depth, and one line a frame for its pose.
//!
//! Source: the data of Gao, Zhang: 14 Lectures on Visual SLAM, chapter 5 (`pose.txt`: `tx ty tz qx qy qz qw`, camera to world, x
//! right, y down, z forward; depth in millimeters), and many like it, which write 12 or 16 numbers of a matrix instead.

use super::place::Place;
use super::reader::{Description, Reader, Reading};
use super::text::TextFile;
use super::views::{
    OPENCV_POSES, colors_in, entry, lens, pictures_in, pose_of_quaternion, pose_of_rows, recording,
};
use crate::capture::transforms::Keys;
use crate::error::Result;
use crate::plural::counted;

/// Names of the files of poses.
const POSES: [&str; 2] = ["pose.txt", "poses.txt"];
/// Names of the folders of color.
const COLORS: [&str; 2] = ["color", "rgb"];
/// Name of the file of the lens, where there is one.
const INTRINSICS: &str = "camera-intrinsics.txt";

/// The folder of the book.
pub(super) struct PoseList;

impl Reader for PoseList {
    fn source(&self) -> &'static str {
        "RGB-D folder with a list of poses"
    }

    fn marks(&self) -> &'static str {
        "pose.txt beside color/ and depth/ (Kinect folders)"
    }

    fn recognizes(&self, place: &Place) -> bool {
        let is_ours = place.file.as_deref().is_none_or(|file| POSES.contains(&file));
        is_ours && place.first_of(&POSES).is_some() && place.first_of(&COLORS).is_some() && place.has("depth")
    }

    fn read(&self, place: &Place) -> Result<Reading> {
        let path = place.join(place.first_of(&POSES).unwrap_or(POSES[0]));
        let folder = place.first_of(&COLORS).unwrap_or(COLORS[0]);
        let mut description = Description {
            source: self.source().to_owned(),
            poses: OPENCV_POSES.to_owned(),
            depth: "planar z in millimeters, 16-bit PGM or PNG; 0 is no depth".to_owned(),
            ..Description::default()
        };
        let colors = colors_in(&place.join(folder));
        let depths = pictures_in(&place.join("depth"), &[".pgm", ".png"]);
        let mut poses = Vec::new();
        for line in TextFile::read(&path)?.lines() {
            poses.push(match line.fields.len() {
                7 => {
                    let [x, y, z, qx, qy, qz, qw] = line.numbers(0)?;
                    pose_of_quaternion([qx, qy, qz, qw], [x, y, z])
                }
                12 => pose_of_rows(&line.numbers::<12>(0)?),
                16 => pose_of_rows(&line.numbers::<16>(0)?),
                count => {
                    let what = format!(
                        "the line has {}; a pose has 7 (tx ty tz qx qy qz qw), 12 or 16",
                        counted(count, "number")
                    );
                    return Err(line.error(what));
                }
            });
        }
        let mut frames = Vec::new();
        for (index, color) in colors.into_iter().enumerate() {
            match (poses.get(index), depths.get(index)) {
                (Some(Some(pose)), Some(depth)) => {
                    frames.push(entry(format!("{folder}/{color}"), Some(format!("depth/{depth}")), pose));
                }
                _ => description.skip("without depth or a pose", color),
            }
        }
        let mut inputs = vec![path];
        let lens_file = place.join(INTRINSICS);
        let [fx, fy, cx, cy] =
            match lens_file.is_file().then(|| TextFile::read(&lens_file)?.numbers()).transpose()? {
                Some(numbers) if numbers.len() >= 9 => {
                    inputs.push(lens_file);
                    description.lens = format!("{INTRINSICS}: {numbers:?}");
                    [numbers[0], numbers[4], numbers[2], numbers[5]]
                }
                _ => {
                    description.lens =
                        String::from("518 519 325.5 253.5, the book's Kinect, as the folder says nothing");
                    [518.0, 519.0, 325.5, 253.5]
                }
            };
        let keys = Keys { depth_unit_scale_factor: Some(1e-3), ..lens(fx, fy, cx, cy, 0.0) };
        recording(place, keys, frames, description, inputs)
    }
}
