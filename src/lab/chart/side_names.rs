//! The names of two sides that are compared, below a picture: the first at its left, the second at its right.

use image::RgbaImage;

use super::color_bar::{Strip, strip_look};
use super::svg::{Anchor, Svg};
use super::type_metrics::{check_letters, text_width};
use overlook_engine::error::Result;
use overlook_engine::render::Picture;
use overlook_engine::render::output::with_below;

/// Rows above and below the names together, as a multiple of the size of the type.
const ROWS: f64 = 2.0;

/// Where the names stand below the top, as a multiple of it.
const BASELINE: f64 = 1.35;

/// The color of the name of a side that is not shown.
const UNSEEN: &str = "#b4bac2";

/// Which sides are shown: both, the first, the second.
const SHOWN: [[bool; 2]; 3] = [[true, true], [true, false], [false, true]];

/// The names of two sides, ready for below pictures of one width.
#[derive(Clone, Debug)]
pub struct SideNames {
    /// For each of [`SHOWN`].
    strips: [RgbaImage; 3],
}

impl SideNames {
    /// For below pictures of so many columns. Names that are too long end in an ellipsis.
    ///
    /// # Errors
    /// `Invalid` where its typeface lacks a letter; else as [`Chart::png`](super::Chart::png).
    pub fn new(names: &[String; 2], columns: usize) -> Result<Self> {
        names.iter().try_for_each(|name| check_letters(name, "names of the sides", "rename the file"))?;
        let [both, first, second] = SHOWN.map(|shown| strip(names, columns, shown));
        Ok(Self { strips: [both?, first?, second?] })
    }

    /// Rows of the names below pictures of so many columns: an even number, so that films stay whole.
    #[must_use]
    pub fn rows(columns: usize) -> usize {
        ((ROWS * strip_look(columns).type_size).ceil() as usize).next_multiple_of(2)
    }

    /// A picture with the names below it; the name of a side that is not `shown` is faint.
    ///
    /// # Panics
    /// Where the picture is not as wide as the names.
    #[must_use]
    pub fn below(&self, picture: &Picture, shown: [bool; 2]) -> Picture {
        let at = SHOWN.iter().position(|known| *known == shown).unwrap_or(0);
        with_below(picture, &self.strips[at])
    }
}

fn strip(names: &[String; 2], columns: usize, shown: [bool; 2]) -> Result<RgbaImage> {
    let look = strip_look(columns);
    let room = (look.columns - 4.0 * look.inset) / 2.0;
    let mut body = Svg::part();
    let ends = [(look.inset, Anchor::Start), (look.columns - look.inset, Anchor::End)];
    for ((name, is_shown), (x, anchor)) in names.iter().zip(shown).zip(ends) {
        let ink = if is_shown { look.ink } else { UNSEEN };
        let name = shortened(name, room, look.type_size);
        body.text((x, BASELINE * look.type_size), anchor, look.type_size, ink, &name);
    }
    Strip { columns, rows: SideNames::rows(columns) }.png_of(&body)
}

/// A name in so many pixels; its end is left out where it is wider.
fn shortened(name: &str, room: f64, type_size: f64) -> String {
    if text_width(name, type_size) <= room {
        return name.to_owned();
    }
    let mut kept = name.to_owned();
    while kept.pop().is_some() {
        let short = format!("{}…", kept.trim_end());
        if text_width(&short, type_size) <= room {
            return short;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The darkest channel in some columns of a strip.
    fn darkest(strip: &RgbaImage, columns: std::ops::Range<u32>) -> u8 {
        let inside = strip.enumerate_pixels().filter(|(x, ..)| columns.contains(x));
        inside.map(|(_, _, pixel)| pixel.0[0]).min().unwrap()
    }

    #[test]
    fn the_name_of_the_side_that_is_shown_stands_out_at_its_end() {
        let names = SideNames::new(&["All samples".to_owned(), "Kept samples".to_owned()], 640).unwrap();
        for strip in &names.strips {
            assert_eq!(strip.dimensions(), (640, SideNames::rows(640) as u32));
            assert_eq!(darkest(strip, 200..440), 255, "nothing stands in the middle");
        }
        let [both, first, second] =
            names.strips.clone().map(|strip| [0..200, 440..640].map(|part| darkest(&strip, part)));
        assert!(both[0] < 60 && both[1] < 60, "{both:?}");
        assert!(first[0] < 60 && first[1] > 120 && second[0] > 120 && second[1] < 60, "{first:?} {second:?}");
        let picture = Picture::empty(640, 4);
        assert_eq!(names.below(&picture, [true, false]).color.size(), (640, 4 + SideNames::rows(640)));
        assert!(SideNames::rows(641).is_multiple_of(2));
    }

    #[test]
    fn names_that_are_too_long_leave_room_for_each_other() {
        let long = "the quite long name of a store with everything in it".to_owned();
        let names = SideNames::new(&[long.clone(), long], 320).unwrap();
        assert_eq!(darkest(&names.strips[0], 154..166), 255);
    }

    #[test]
    fn a_name_with_a_letter_that_the_typeface_lacks_is_refused() {
        let said = SideNames::new(&["kept".to_owned(), "全部".to_owned()], 320).unwrap_err().to_string();
        assert!(said.contains("no letter '全' (U+5168)") && said.contains("rename the file"), "{said}");
    }
}
