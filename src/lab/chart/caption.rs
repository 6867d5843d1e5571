//! A caption below pictures on a screen, as those of a film.

use std::borrow::Cow;

use image::RgbaImage;

use super::color_bar::{Strip, strip_look};
use super::svg::{Anchor, Svg};
use super::type_metrics::{check_letters, lines, text_width};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::Picture;
use overlook_engine::render::output::with_below;

/// Distance of lines, and room below the last one, as multiples of the size of the type.
const LINE: f64 = 1.35;
const BELOW: f64 = 0.65;

/// A text, ready for below pictures of one width; nothing for an empty text.
#[derive(Clone, Debug)]
pub struct Caption {
    strip: RgbaImage,
}

impl Caption {
    /// For below pictures of so many columns, in as many lines as it takes.
    ///
    /// # Errors
    /// `Invalid` where its typeface lacks a letter, or a word is wider than the pictures.
    pub fn new(text: &str, columns: usize) -> Result<Self> {
        check_letters(text, "caption", "write it otherwise")?;
        let look = strip_look(columns);
        let (size, room) = (look.type_size, look.columns - 2.0 * look.inset);
        let lines = lines(text, size, room);
        if lines.is_empty() {
            return Ok(Self { strip: RgbaImage::new(columns as u32, 0) });
        }
        if let Some(line) = lines.iter().find(|line| text_width(line, size) > room) {
            let what = format!("'{line}' is wider than pictures of {columns} columns; write it shorter");
            return Err(Error::invalid("caption", what));
        }
        let mut body = Svg::part();
        for (nth, line) in (1..).zip(&lines) {
            body.text((look.inset, f64::from(nth) * LINE * size), Anchor::Start, size, look.ink, line);
        }
        // An even number, so that films stay whole.
        let rows = (((lines.len() as f64 * LINE + BELOW) * size).ceil() as usize).next_multiple_of(2);
        Ok(Self { strip: Strip { columns, rows }.png_of(&body)? })
    }

    /// Rows that it takes, an even number; 0 for an empty text.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.strip.height() as usize
    }

    /// A picture with the caption below it.
    ///
    /// # Panics
    /// Where the picture is not as wide as the caption.
    #[must_use]
    pub fn below<'a>(&self, picture: &'a Picture) -> Cow<'a, Picture> {
        if self.rows() == 0 { Cow::Borrowed(picture) } else { Cow::Owned(with_below(picture, &self.strip)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_takes_as_many_lines_as_it_needs_and_refuses_what_it_cannot_show() {
        let of = |text: &str| Caption::new(text, 320);
        let none = of(" ").unwrap();
        assert_eq!((none.rows(), none.below(&Picture::empty(320, 4)).color.size()), (0, (320, 4)));
        let [short, long] =
            ["The orrery", "The orrery, seen from where no camera stood, as it was pruned by default"]
                .map(|text| of(text).unwrap());
        assert!(
            short.rows() < long.rows() && short.rows().is_multiple_of(2) && long.rows().is_multiple_of(2)
        );
        let picture = Picture::empty(320, 4);
        let with = short.below(&picture);
        assert_eq!(with.color.size(), (320, 4 + short.rows()));
        let brightness: Vec<f32> = with.color.as_slice()[320 * 4..].iter().map(|color| color[0]).collect();
        let [ink, paper] = [f32::min, f32::max].map(|of| brightness.iter().copied().fold(0.5, of));
        assert!(ink < 0.1 && paper > 0.9, "{ink} on {paper}");
        assert!(of("日本").unwrap_err().to_string().contains("'日'"));
        assert!(of(&"m".repeat(60)).unwrap_err().to_string().contains("shorter"));
    }
}
