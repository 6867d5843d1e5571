//! Text files of numbers: every error names file and line.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::whole_file;

/// Largest text file that is read.
const MAX_BYTES: u64 = 1 << 30;

/// A text file in memory.
pub(super) struct TextFile {
    path: PathBuf,
    text: String,
}

/// One line, split at white space and commas.
pub(super) struct TextLine<'a> {
    path: &'a Path,
    /// Counted from 1.
    pub number: usize,
    /// Its fields; there is one at least.
    pub fields: Vec<&'a str>,
    text: &'a str,
}

impl TextFile {
    /// Reads a file as UTF-8, bytes that are not becoming marks, as names of files may hold them.
    ///
    /// # Errors
    /// `Io` where it cannot be read, `Invalid` where it is absurdly large.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let length = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
        if length > MAX_BYTES {
            return Err(Error::invalid(
                path.display(),
                format!("{length} bytes are too many for a text file"),
            ));
        }
        let bytes = whole_file::read_all(path)?;
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
        Ok(Self { path: path.to_path_buf(), text: String::from_utf8_lossy(bytes).into_owned() })
    }

    /// The whole text.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Lines that are neither empty nor comments (`#`).
    pub(super) fn lines(&self) -> impl Iterator<Item = TextLine<'_>> {
        self.text.lines().enumerate().filter_map(|(index, text)| {
            let text = text.trim();
            let separates = |letter: char| letter.is_whitespace() || letter == ',';
            let fields: Vec<&str> = text.split(separates).filter(|field| !field.is_empty()).collect();
            let is_data = !fields.is_empty() && !text.starts_with('#');
            is_data.then_some(TextLine { path: &self.path, number: index + 1, fields, text })
        })
    }

    /// All numbers of the file in their order.
    ///
    /// # Errors
    /// `Invalid` for a field that is no number.
    pub(super) fn numbers(&self) -> Result<Vec<f64>> {
        let mut numbers = Vec::new();
        for line in self.lines() {
            line.check_commas()?;
            for field in &line.fields {
                numbers.push(line.number_in(field)?);
            }
        }
        Ok(numbers)
    }
}

/// Whether two words of a line or more are `digits,digits`, and no word has another comma.
fn has_decimal_commas(line: &str) -> bool {
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_digit());
    let is_decimal = |word: &str| {
        let parts = word.split_once(',');
        parts.is_some_and(|(whole, rest)| {
            is_digits(whole.trim_start_matches(['-', '+']))
                && is_digits(rest.split(['e', 'E']).next().unwrap_or(""))
        })
    };
    let words = || line.split(|letter: char| letter.is_whitespace() || letter == ';');
    let with_commas = words().filter(|word| word.contains(','));
    with_commas.clone().count() >= 2 && with_commas.clone().all(is_decimal)
}

impl TextLine<'_> {
    /// An error in this line.
    pub(super) fn error(&self, what: impl Into<String>) -> Error {
        Error::invalid(format!("{}, line {}", self.path.display(), self.number), what)
    }

    /// A field as a number, which may be infinite or NaN.
    pub(super) fn number_in(&self, field: &str) -> Result<f64> {
        field.parse().map_err(|_| self.error(format!("'{field}' is no number")))
    }

    /// Refuses decimal commas: they would make two numbers of one.
    fn check_commas(&self) -> Result<()> {
        if has_decimal_commas(self.text) {
            return Err(self.error("numbers have decimal commas; write them with points, as in 0.5"));
        }
        Ok(())
    }

    /// The `N` numbers from field `first` on.
    pub(super) fn numbers<const N: usize>(&self, first: usize) -> Result<[f64; N]> {
        self.check_commas()?;
        let mut numbers = [0.0; N];
        for (index, number) in numbers.iter_mut().enumerate() {
            let Some(field) = self.fields.get(first + index) else {
                let what = format!("there are {} fields where {} are expected", self.fields.len(), first + N);
                return Err(self.error(what));
            };
            *number = self.number_in(field)?;
        }
        Ok(numbers)
    }
}
