//! The typeface of charts: how wide a text is in it, and lines of a paragraph.

use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};

use overlook_engine::error::{Error, Result};

/// Its name in SVG.
pub(super) const FAMILY: &str = "Ubuntu";

/// The font file, as TrueType.
pub(super) const FONT: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;

/// Width of a text of a size, in the size's unit, without kerning. Characters that the typeface lacks count as wide as an `x`.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let Ok(font) = FontRef::new(FONT) else { return 0.5 * size * text.chars().count() as f64 };
    let (glyphs, advances) = (font.charmap(), font.glyph_metrics(Size::new(1.0), LocationRef::default()));
    let advance = |character: char| {
        let glyph = glyphs.map(character).or_else(|| glyphs.map('x'))?;
        advances.advance_width(glyph)
    };
    text.chars().filter_map(advance).map(f64::from).sum::<f64>() * size
}

/// Refuses a text with a letter that the typeface lacks. `place` is what it stands in, `remedy` what to do.
pub(super) fn check_letters(text: &str, place: &str, remedy: &str) -> Result<()> {
    let Ok(font) = FontRef::new(FONT) else { return Ok(()) };
    let glyphs = font.charmap();
    let missing = text.chars().find(|letter| !letter.is_whitespace() && glyphs.map(*letter).is_none());
    missing.map_or(Ok(()), |letter| {
        let what = format!(
            "its typeface has no letter '{letter}' (U+{:04X}), which stands in '{text}'; {remedy}",
            u32::from(letter)
        );
        Err(Error::invalid(place, what))
    })
}

/// A text as lines that are no wider than `width` where their words allow it. Line breaks of the text stay.
pub(super) fn lines(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in text.trim().lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if !line.is_empty() && text_width(&longer, size) > width {
                lines.push(std::mem::replace(&mut line, word.to_owned()));
            } else {
                line = longer;
            }
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_all_words_and_their_width() {
        let text =
            "Pixels of the left camera that another camera represents at least as well.\nA second paragraph.";
        let wrapped = lines(text, 10.0, 120.0);
        assert!(wrapped.len() > 3, "{wrapped:?}");
        assert!(wrapped.iter().all(|line| text_width(line, 10.0) <= 120.0), "{wrapped:?}");
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&wrapped.join(" ")), words(text));
        assert_eq!(lines("unbreakable", 10.0, 5.0), ["unbreakable"]);
        assert!(text_width("iiii", 10.0) < text_width("mmmm", 10.0));
    }
}
