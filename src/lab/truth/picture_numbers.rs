//! Counters and times in the names of picture files.
//!
//! Purpose: a recording by one moving camera is a sequence, and the number in a picture's name is its position in the sequence.

/// A file name taken apart at its last number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PictureNumber {
    pub(super) number: f64,
    /// The text before and after the number, which is the same in all names of one sequence.
    around: [String; 2],
}

impl PictureNumber {
    /// Reads a file's name without folder and extension; `None` where it holds no number.
    pub(super) fn of(stem: &str) -> Option<Self> {
        let is_digit = |letter: u8| letter.is_ascii_digit();
        let bytes = stem.as_bytes();
        let end = 1 + bytes.iter().rposition(|letter| is_digit(*letter))?;
        let run = |end: usize| {
            bytes[..end].iter().rposition(|letter| !is_digit(*letter)).map_or(0, |before| before + 1)
        };
        let mut start = run(end);
        // A time in seconds has its fraction after a point.
        if start >= 2 && bytes[start - 1] == b'.' && is_digit(bytes[start - 2]) {
            start = run(start - 1);
        }
        let number = stem[start..end].parse().ok()?;
        Some(Self { number, around: [stem[..start].to_owned(), stem[end..].to_owned()] })
    }

    /// Whether both are of one sequence.
    pub(super) fn is_beside(&self, other: &Self) -> bool {
        self.around == other.around
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_recordings_are_taken_apart_at_the_number_that_counts() {
        let of = |stem: &str| PictureNumber::of(stem).map(|found| found.number);
        assert_eq!(of("229529"), Some(229_529.0));
        assert_eq!(of("1305031102.175304"), Some(1_305_031_102.175_304));
        assert_eq!(of("frame-000123.color"), Some(123.0));
        assert_eq!(of("IMG_2041"), Some(2041.0));
        assert_eq!(of("left"), None);
        let found = |stem: &str| PictureNumber::of(stem).unwrap();
        assert!(found("frame-1.color").is_beside(&found("frame-12.color")));
        assert!(!found("frame-1.color").is_beside(&found("frame-1.depth")));
    }
}
