//! The address of a view, as the page that plays a scene writes it too (`assets/page/address.js`):
//!
//! ```text
//! scene.ovl#view=x,y,z,qx,qy,qz,qw,distance&frame=number[&lens=width,height,fx,fy,cx,cy][&camera=name]
//! ```
//!
//! `x, y, z` is the place in world space; the quaternion turns camera space (x right, y down, z forward) into world space; `distance` is
//! how far ahead the pivot of orbiting is. `lens` is left out where it is that of the first camera. `camera` stands for the view of a
//! camera. What precedes the `#` is a capture, a store, a page, or nothing.

use std::fmt::{self, Display};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::{DAffine3, DQuat, DVec3};

use overlook_engine::capture::Intrinsics;

/// Digits of a number behind its first: as many as no picture shows a difference of, even of a scene far from the origin.
const DIGITS: usize = 11;

/// Numbers of a view: place, quaternion, distance of the pivot.
const OF_VIEW: usize = 8;

/// Longest side of a lens that is read, pixels.
const LONGEST_SIDE: f64 = 65_536.0;

/// What an address says of a view; what it does not say is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ViewAddress {
    /// Place in world space, quaternion from camera space to world space, and distance of the pivot, above 0. All are finite, and the
    /// quaternion's length is above a half.
    view: Option<[f64; OF_VIEW]>,
    /// Name of the camera whose view it is, where `view` is missing.
    pub(crate) camera: Option<String>,
    /// The lens; that of the first camera where `view` is there alone.
    pub(crate) lens: Option<Intrinsics>,
    /// Number of the frame in the capture.
    pub(crate) frame_number: Option<i64>,
}

impl ViewAddress {
    /// The address of a pose (camera space to world space) whose pivot is `pivot_distance` ahead, at a frame, in a scene whose first
    /// camera has the lens `usual`. Numbers are rounded to twelve digits.
    pub(crate) fn of(
        world_from_camera: &DAffine3,
        pivot_distance: f64,
        [lens, usual]: [Intrinsics; 2],
        frame_number: i64,
    ) -> Self {
        let turn = DQuat::from_mat3(&world_from_camera.matrix3).normalize();
        let [x, y, z] = world_from_camera.translation.to_array();
        let [qx, qy, qz, qw] = turn.to_array();
        let lens = (lens != usual).then(|| Intrinsics {
            fx: rounded(lens.fx),
            fy: rounded(lens.fy),
            cx: rounded(lens.cx),
            cy: rounded(lens.cy),
            ..lens
        });
        Self {
            view: Some([x, y, z, qx, qy, qz, qw, pivot_distance].map(rounded)),
            camera: None,
            lens,
            frame_number: Some(frame_number),
        }
    }

    /// Camera space to world space, and the distance of the pivot; the same to the last bit for the same address.
    pub(crate) fn pose(&self) -> Option<(DAffine3, f64)> {
        let [x, y, z, qx, qy, qz, qw, pivot_distance] = self.view?;
        let turn = DQuat::from_xyzw(qx, qy, qz, qw).normalize();
        Some((DAffine3::from_rotation_translation(turn, DVec3::new(x, y, z)), pivot_distance))
    }

    /// Reads what follows the `#` of an address. Parts that say nothing sensible are left out; `None` where all are.
    pub(crate) fn read(fragment: &str) -> Option<Self> {
        let mut read = Self::default();
        for field in fragment.split('&') {
            let (name, value) = field.split_once('=').unwrap_or((field, ""));
            let value = decoded(value);
            match name {
                "view" => read.view = numbers(&value).filter(is_view),
                "camera" if !value.is_empty() => read.camera = Some(value),
                "lens" => read.lens = numbers(&value).and_then(lens_of),
                // As a page does: a number between frames means the next one.
                "frame" => read.frame_number = numbers(&value).map(|[number]| number.ceil() as i64),
                _ => {}
            }
        }
        let says_something = read.view.is_some() || read.camera.is_some() || read.frame_number.is_some();
        says_something.then_some(read)
    }
}

impl FromStr for ViewAddress {
    type Err = &'static str;

    /// With the `#` or without.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let read = Self::read(text.trim_start_matches('#'));
        read.ok_or("it is no address; write it as #view=…&frame=…")
    }
}

impl Display for ViewAddress {
    /// With the `#`.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = Vec::new();
        if let Some(view) = &self.view {
            fields.push(format!("view={}", joined(view)));
        }
        if let Some(camera) = &self.camera {
            fields.push(format!("camera={}", encoded(camera)));
        }
        if let Some(number) = self.frame_number {
            fields.push(format!("frame={number}"));
        }
        if let Some(lens) = &self.lens {
            let sides = [lens.width, lens.height].map(f64::from);
            fields.push(format!("lens={},{}", joined(&sides), joined(&[lens.fx, lens.fy, lens.cx, lens.cy])));
        }
        write!(formatter, "#{}", fields.join("&"))
    }
}

/// What precedes the `#` of an address, and the view; `None` where a text is no address.
pub(crate) fn split(text: &str) -> Option<(String, ViewAddress)> {
    let (place, fragment) = text.trim().rsplit_once('#')?;
    let view = ViewAddress::read(fragment)?;
    let place = place.strip_prefix("file://").map_or_else(|| place.to_owned(), decoded);
    Some((place, view))
}

/// The path that an argument means, and the view of it if the argument is an address. What exists under the whole name is that.
pub(crate) fn of_path(path: &Path) -> (PathBuf, Option<ViewAddress>) {
    let address = path.to_str().filter(|_| !path.exists()).and_then(split);
    match address {
        Some((place, view)) if !place.is_empty() => (place.into(), Some(view)),
        _ => (path.to_path_buf(), None),
    }
}

/// Whether what precedes the `#` is a page, which holds a view of the scene and not the scene.
pub(crate) fn is_page(place: &str) -> bool {
    let ending = Path::new(place).extension().unwrap_or_default();
    place.starts_with("http") || ["html", "htm"].iter().any(|page| ending.eq_ignore_ascii_case(page))
}

fn is_view(view: &[f64; OF_VIEW]) -> bool {
    let length = view[3..7].iter().map(|part| part * part).sum::<f64>().sqrt();
    length > 0.5 && length.is_finite() && view[7] > 0.0
}

fn lens_of([width, height, fx, fy, cx, cy]: [f64; 6]) -> Option<Intrinsics> {
    let is_side = |side: f64| (1.0..=LONGEST_SIDE).contains(&side) && side.fract() == 0.0;
    let is_lens = is_side(width) && is_side(height) && fx > 0.0 && fy > 0.0;
    is_lens.then_some(Intrinsics { fy, cx, cy, ..Intrinsics::centered(width as u32, height as u32, fx) })
}

/// Exactly so many finite numbers, parted by commas.
fn numbers<const COUNT: usize>(text: &str) -> Option<[f64; COUNT]> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|number| number.trim().parse().ok().filter(|number: &f64| number.is_finite()))
        .collect();
    numbers?.try_into().ok()
}

fn rounded(number: f64) -> f64 {
    format!("{number:.DIGITS$e}").parse().unwrap_or(number)
}

/// Numbers as short as they can be read again to the last bit.
fn joined(numbers: &[f64]) -> String {
    let short = |number: &f64| {
        let text = format!("{number:?}");
        text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
    };
    numbers.iter().map(short).collect::<Vec<_>>().join(",")
}

/// A text in which `%2C` and its like are the letters that they stand for; what is no such code stays.
fn decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).filter(|_| *first == b'%').and_then(|code| std::str::from_utf8(code).ok());
        if let Some(byte) = code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            bytes.push(byte);
            rest = &after[2..];
        } else {
            bytes.push(*first);
            rest = after;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A text without the letters that part the fields of an address.
fn encoded(text: &str) -> String {
    let letter = |letter: char| match letter {
        '%' | '&' | '#' | '=' | '+' | ' ' => format!("%{:02X}", letter as u32),
        letter => letter.to_string(),
    };
    text.chars().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lens() -> Intrinsics {
        Intrinsics::from_horizontal_angle(640, 480, 1.0)
    }

    proptest! {
        #[test]
        fn an_address_that_is_written_is_read_as_it_was_to_the_last_bit(
            place in prop::array::uniform3(-1e7_f64..1e7),
            axis in prop::array::uniform3(-1.0_f64..1.0),
            angle in -7.0_f64..7.0,
            distance in 1e-6_f64..1e6,
            focal in 1.0_f64..1e4,
            frame_number in -1000_i64..100_000,
        ) {
            let axis = DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::X);
            let pose = DAffine3::from_rotation_translation(
                DQuat::from_axis_angle(axis, angle),
                DVec3::from_array(place),
            );
            let own = Intrinsics { fx: focal, fy: 1.1 * focal, cx: focal / 3.0, ..lens() };
            for lenses in [[lens(), lens()], [own, lens()]] {
                let address = ViewAddress::of(&pose, distance, lenses, frame_number);
                let (place, read) = split(&format!("a b/scene.ovl{address}")).unwrap();
                prop_assert_eq!(place, "a b/scene.ovl");
                prop_assert_eq!(read.pose(), address.pose());
                prop_assert_eq!(read.to_string(), address.to_string());
                prop_assert_eq!(&read, &address);
                let (again, pivot_distance) = read.pose().unwrap();
                prop_assert!((again.translation - pose.translation).length() <= 1e-11 * pose.translation.length());
                prop_assert!((pivot_distance - distance).abs() <= 1e-11 * distance);
                let apart = (again.matrix3 - pose.matrix3).to_cols_array().map(f64::abs);
                prop_assert!(apart.into_iter().all(|apart| apart < 1e-10));
            }
        }

        #[test]
        fn whatever_is_pasted_is_read_without_harm(text in ".{0,80}", place in "[a-z#%]{0,8}") {
            if let Some((_, view)) = split(&format!("{place}#view={text}&frame={text}&lens={text}")) {
                prop_assert!(view.pose().is_none_or(|(pose, distance)| pose.is_finite() && distance > 0.0));
            }
        }
    }

    #[test]
    fn an_address_as_a_page_writes_it_is_read() {
        let text = "file:///tmp/my%20scene.html#view=1,-2.5,3e-7,0,0,0.6,0.8,4.25&frame=17&lens=1280,720,1000.5,1000.5,640,360&bare";
        let (place, view) = split(text).unwrap();
        assert!(place == "/tmp/my scene.html" && is_page(&place) && !is_page("scene.ovl"));
        let (pose, pivot_distance) = view.pose().unwrap();
        assert_eq!((pose.translation, pivot_distance), (DVec3::new(1.0, -2.5, 3e-7), 4.25));
        let lens = view.lens.unwrap();
        assert_eq!((lens.width, lens.height, lens.fx), (1280, 720, 1000.5));
        assert_eq!(view.frame_number, Some(17));
        let (_, coded) = split("#view=1%2C2%2C3%2C0%2C0%2C0%2C1%2C5&camera=far%20left").unwrap();
        assert!(coded.pose().is_some() && coded.camera.as_deref() == Some("far left"));
        assert!(split(&coded.to_string()).unwrap().1 == coded);
    }

    #[test]
    fn what_says_nothing_sensible_is_left_out() {
        for none in [
            "scene.ovl",
            "#",
            "scene.ovl#view=1,2,3",
            "#view=1,2,3,0,0,0,0,5",
            "#view=1,2,3,0,0,0,1,-5",
            "#frame=x",
        ] {
            assert_eq!(split(none), None, "{none}");
        }
        let (_, view) = split("#view=nonsense&frame=3&lens=0,0,1,1,0,0").unwrap();
        assert_eq!((view.pose(), view.lens, view.frame_number), (None, None, Some(3)));
    }

    #[test]
    fn a_file_that_has_such_a_name_is_that_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a#frame=3");
        let without = folder.path().join("a");
        assert_eq!(of_path(&path).0, without);
        std::fs::write(&path, "").unwrap();
        assert_eq!(of_path(&path), (path, None));
        assert_eq!(of_path(Path::new("#frame=3")), ("#frame=3".into(), None));
    }
}
