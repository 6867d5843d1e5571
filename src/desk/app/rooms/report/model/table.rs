//! Tables that can be copied and saved.

use std::path::Path;

/// A form that tables are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableForm {
    Csv,
    Markdown,
    Latex,
}

impl TableForm {
    /// Every form: its name, and the ending of its files.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] =
        [(Self::Csv, "CSV", "csv"), (Self::Markdown, "Markdown", "md"), (Self::Latex, "LaTeX", "tex")];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(form, ..)| *form == self).map_or("", |(_, name, _)| name)
    }

    /// The form of a file, by its ending; CSV where that says nothing.
    pub(crate) fn of_file(path: &Path) -> Self {
        let has = |ending: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
        Self::ALL.iter().find(|(.., ending)| has(ending)).map_or(Self::Csv, |(form, ..)| *form)
    }
}

/// A table that can be copied or saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Table {
    Sweep,
    StressTest,
    /// Which camera's samples replace whose.
    Replacements,
    /// How far cameras are off each other.
    Agreement,
    /// What was corrected of cameras.
    Alignment,
    /// The evidence of every camera about the selected pixel.
    Pixel,
    Cameras,
    /// What was kept of all pixels, and why the rest was dropped.
    Pixels,
    /// What the samples of each camera take in memory.
    Memory,
    /// How many samples each span of frames has.
    Spans,
}

impl Table {
    /// Every table: what it is called in commands, and its file.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 10] = [
        (Self::Sweep, "sweep", "sweep.csv"),
        (Self::StressTest, "stress test", "stress.csv"),
        (Self::Replacements, "matrix of replaced samples", "replacements.csv"),
        (Self::Agreement, "matrix of agreement", "agreement.csv"),
        (Self::Alignment, "table of corrections", "alignment.csv"),
        (Self::Pixel, "pixel table", "pixel.csv"),
        (Self::Cameras, "camera table", "cameras.csv"),
        (Self::Pixels, "table of all pixels", "pixels.csv"),
        (Self::Memory, "memory table", "memory.csv"),
        (Self::Spans, "span table", "spans.csv"),
    ];

    /// What it is called in commands.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(_, name, _)| name)
    }

    /// Name of its file.
    pub(crate) fn file(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(.., file)| file)
    }
}
